"""Hook of the build: compile the engine into the package."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).resolve().parent))
import build_engine


class EngineHook(BuildHookInterface):
    """Compiles the engine for wheels and for editable installations; sources go as they are."""

    def dependencies(self) -> list[str]:
        """A compiler from the package index, only where the machine has none."""
        try:
            build_engine.compiler(build_engine.chosen_platform())
        except SystemExit:
            return ["ziglang>=0.13"]
        return []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and tell the wheel what it holds."""
        if self.target_name != "wheel":
            return
        root = Path(self.root)
        for path in build_engine.build():
            build_data["artifacts"].append(path.relative_to(root).as_posix())
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{build_engine.chosen_platform().tag}"
