"""Compile the engine: C++ sources to shared libraries, and their declarations to Python.

`python build_engine.py` compiles in a folder of the sources; building the package calls `build`
(hatch_build.py). The libraries have a plain C interface and know nothing of Python, so one wheel
serves all versions.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path
from typing import NamedTuple

ENGINE = Path(__file__).resolve().parent / "src" / "nonsmooth" / "engine"
SOURCES = ENGINE / "native"
DECLARATIONS = ENGINE / "_declarations.py"
DEVICE_SOURCE = ENGINE / "_device.cu"

# Contraction of products and sums is a matter of the processor: without it all builds give the same
# digits. Optimisations that assume finite numbers, or change the order of sums, would break the
# certificate.
FLAGS = [
    "-std=c++20", "-O3", "-fPIC", "-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math",
    "-fno-exceptions", "-fno-rtti", "-fvisibility=hidden", "-Wall", "-Wextra",
    "-Wno-psabi",  # vectors are passed between functions of this library alone
]  # fmt: skip
# Loops over states run two to six times: turned into vectors or calls of memmove by GCC they take
# longer, a twentieth of a run. What pays as vectors is written as such (sixteen.hpp, lanes).
OF_GCC = ["-fno-tree-loop-vectorize", "-fno-tree-loop-distribute-patterns"]


# two thirds of the time that a library takes
LONGEST_UNITS = ("taylor_kernels", "run", "closed_run")


class Platform(NamedTuple):
    """What a library is built for."""

    zig: str  # the target in words of Zig; empty for this machine and its own compiler
    suffix: str
    tag: str  # of the wheel
    machine: str


def _wheel_tag() -> str:
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


_OWN_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")
_LINUX = "manylinux_2_17_{0}.manylinux2014_{0}"
# $NONSMOOTH_PLATFORM names one of these; without it the library is for this machine.
PLATFORMS = {
    "": Platform("", _OWN_SUFFIX, _wheel_tag(), platform.machine().lower()),
    "linux-x86_64": Platform("x86_64-linux-gnu.2.17", ".so", _LINUX.format("x86_64"), "x86_64"),
    "linux-aarch64": Platform("aarch64-linux-gnu.2.17", ".so", _LINUX.format("aarch64"), "aarch64"),
    "macos-x86_64": Platform("x86_64-macos", ".dylib", "macosx_11_0_x86_64", "x86_64"),
    "macos-arm64": Platform("aarch64-macos", ".dylib", "macosx_11_0_arm64", "arm64"),
    "windows-x86_64": Platform("x86_64-windows-gnu", ".dll", "win_amd64", "amd64"),
}


def chosen_platform() -> Platform:
    """Platform that the environment asks for."""
    name = os.environ.get("NONSMOOTH_PLATFORM", "")
    if name not in PLATFORMS:
        known = ", ".join(each for each in PLATFORMS if each)
        raise SystemExit(f"NONSMOOTH_PLATFORM is {name!r}; known are {known}")
    return PLATFORMS[name]


def builds(aim: Platform) -> dict[str, list[str]]:
    """Names of the libraries to build and what their processors allow."""
    if aim.machine not in ("x86_64", "amd64"):
        return {"baseline": []}
    if "ziglang" in compiler(aim):
        return {"baseline": ["-mcpu=x86_64"], "v3": ["-mcpu=x86_64_v3"]}
    # GCC 12 joins products with sums and differences side by side (vfmaddsub) in spite of
    # -ffp-contract=off, which breaks sums in doubled precision: no such instructions at all
    return {"baseline": ["-march=x86-64"], "v3": ["-march=x86-64-v3", "-mno-fma"]}


def compiler(aim: Platform = PLATFORMS[""]) -> list[str]:
    """Command of a C++20 compiler: $CXX, one on the path, or that of the package ziglang."""
    for name in () if aim.zig else (os.environ.get("CXX"), "c++", "g++", "clang++"):
        if name and shutil.which(name.split()[0]):
            return name.split()
    if importlib.util.find_spec("ziglang"):
        target = ["-target", aim.zig] if aim.zig else []
        return [sys.executable, "-m", "ziglang", "c++", "-fno-sanitize=all", *target]
    raise SystemExit(
        "no C++ compiler was found. Install one that knows C++20 (GCC 11, Clang 14 or newer), name"
        " yours in the environment variable CXX, or `pip install ziglang`, which brings one"
    )


def is_gcc(command: list[str]) -> bool:
    """Whether a compiler is GCC, whatever it is called."""
    told = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False)
    return "Free Software Foundation" in told.stdout


def sources_hash() -> str:
    """Hash of the sources and of this file, which has the flags that they are compiled with."""
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(SOURCES.iterdir()):
        if path.suffix in (".h", ".hpp", ".cpp", ".cu"):
            digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def library(build: str, aim: Platform) -> Path:
    """Path of a library."""
    return ENGINE / f"_nonsmooth_{build}{aim.suffix}"


def declarations() -> str:
    """The declarations of interface.h in plain C: ``Array(T, d)`` becomes a struct of its own."""
    text = re.sub(r"/\*.*?\*/", "", (SOURCES / "interface.h").read_text(), flags=re.DOTALL)
    arrays = sorted(set(re.findall(r"Array\((\w+), (\d)\)", text)))
    text = re.sub(r"Array\((\w+), (\d)\)", r"Array_\1_\2", text)
    structs = "".join(
        f"typedef struct Array_{of}_{axes} {{ {of} *data; int64_t shape[{axes}]; }}"
        f" Array_{of}_{axes};\n"
        for of, axes in arrays
    )
    rows, records = text.split("typedef struct Program", 1)
    complexes = "typedef struct Complex { double re, im; } Complex;\n"
    return complexes + rows + structs + "typedef struct Program" + records


def write_declarations() -> None:
    """Write the declarations as a Python module that needs no parsing when it is imported."""
    from cffi import FFI

    ffi = FFI()
    ffi.cdef(declarations())
    ffi.set_source("nonsmooth.engine._declarations", None)
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(None):
        made = Path(folder) / "declarations.py"
        ffi.emit_python_code(str(made))
        _replace(made, DECLARATIONS)


def device_source() -> str:
    """The kernels for graphics devices as one text, which their compiler reads without files.

    It includes the C++ library where there is one; elsewhere device_standard.hpp stands for it.
    """
    standard: list[str] = []
    known: set[str] = set()

    def text_of(name: str) -> str:
        known.add(name)
        lines = []
        for line in (SOURCES / name).read_text().splitlines():
            if found := re.match(r'#include "(.*)"', line):
                if found[1] not in known:
                    lines.append(text_of(found[1]))
            elif line.startswith("#include <"):
                standard.append(line)
            elif line != "#pragma once":
                lines.append(line)
        return "\n".join(lines)

    body, own = text_of("device.cu"), text_of("device_standard.hpp")
    headers = "\n".join(sorted(set(standard)))
    return f"#ifdef __CUDACC_RTC__\n{own}\n#else\n{headers}\n#endif\n{body}\n"


def _replace(made: Path, target: Path) -> None:
    """Put a file in place at once: another process may be reading the old one."""
    beside = target.with_name(f"{target.name}.{os.getpid()}")
    shutil.copyfile(made, beside)
    os.replace(beside, target)


def compile_libraries(libraries: dict[Path, list[str]], aim: Platform) -> None:
    """Compile the units of some libraries side by side, each with its flags, and link them."""
    command = compiler(aim)
    further = OF_GCC if is_gcc(command) else []
    with tempfile.TemporaryDirectory() as folder:

        def made(unit: Path, path: Path) -> str:
            return str(Path(folder) / f"{path.stem}.{unit.stem}.o")

        def compile_unit(unit: Path, path: Path) -> None:
            define = f'-DNONSMOOTH_SOURCES="{sources_hash()}"'
            flags = [*FLAGS, *libraries[path], *further, define]
            subprocess.run([*command, *flags, "-c", str(unit), "-o", made(unit, path)], check=True)

        # the longest first, which would otherwise run alone at the end
        units = sorted(SOURCES.glob("*.cpp"), key=lambda unit: unit.stem not in LONGEST_UNITS)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(compile_unit, *zip(*product(units, libraries), strict=True)))
        for path, flags in libraries.items():
            linked = Path(folder) / f"{path.stem}{aim.suffix}"
            objects = [made(unit, path) for unit in units]
            parts = [*command, "-shared", *flags, *further, *objects, "-o", str(linked)]
            if "ziglang" in command:  # its C++ library takes minutes to build: the engine uses none
                parts.append("-nostdlib++")
            if aim.suffix != ".dll":
                parts.append("-lm")
            subprocess.run(parts, check=True)
            _replace(linked, path)


def build_libraries() -> list[Path]:
    """Compile the libraries that are not current; returns the paths of all.

    It needs the compiler alone, so it may run while packages are being installed.
    """
    aim = chosen_platform()
    flags = {library(name, aim): flags for name, flags in builds(aim).items()}
    old = {path: each for path, each in flags.items() if aim.zig or not is_current(path)}
    if old:
        compile_libraries(old, aim)
    return list(flags)


def build() -> list[Path]:
    """Compile all libraries and write the declarations; returns their paths."""
    made = build_libraries()
    write_declarations()
    DEVICE_SOURCE.write_text(device_source())
    return [*made, DECLARATIONS, DEVICE_SOURCE]


def is_current(path: Path) -> bool:
    """Whether a library was compiled from these very sources, whose hash it carries."""
    return path.exists() and sources_hash().encode() in path.read_bytes()


def build_sanitized(path: Path) -> None:
    """A library that looks after its own addresses and undefined behaviour, for tests."""
    path.parent.mkdir(parents=True, exist_ok=True)
    flags = ["-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined"]
    compile_libraries({path: flags}, PLATFORMS[""])


if __name__ == "__main__":
    if sys.argv[1:2] == ["--sanitized"]:
        build_sanitized(Path(sys.argv[2]))
    elif sys.argv[1:2] == ["--libraries"]:
        build_libraries()
    else:
        for each in build():
            print(each)
