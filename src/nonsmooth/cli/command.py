"""A command: options made from the signatures of its verbs, and what each run of it shares.

The entry of a command in `nonsmooth.cli.table` names its verbs and its function. The function is
imported when the command runs, the source of the verbs is read when its options are asked for.
"""

from __future__ import annotations

import importlib
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource
from click.shell_completion import CompletionItem

from nonsmooth.cli.arguments import build_system, refuse_fixed, settings, whole_names
from nonsmooth.cli.console import ENDED_EARLY, INTERRUPTED
from nonsmooth.cli.options import Own, flag, own_option, verb_option
from nonsmooth.cli.signatures import parameters
from nonsmooth.cli.wording import advice_in_words_of_shell, error_in_words_of_shell
from nonsmooth.errors import OptionError, ResultWarning, RunError, RunWarning

if TYPE_CHECKING:
    import xarray as xr

    from nonsmooth.cli.report import Report
    from nonsmooth.system.system import System

__all__ = ["LEFT_OUT", "PICTURES", "RENAMED", "Entry", "Task", "VerbCommand", "taken"]

PICTURES = (".png", ".pdf", ".svg")

# Parameters of verbs that are no options, and why.
LEFT_OUT = {
    "system": "it is the argument MODEL",
    "parameters": "they are the arguments NAME=VALUE",
    "parameter": "--over names it",
    "values": "--over gives them",
    "region": "--over gives it",
    "over": "it has a form of its own in each command",
    "t_start": "runs of the command line begin at the time 0",
    "times": "a list of instants is a matter of scripts",
    "tangent": "no summary shows derivatives",
    "events": "the option --no-events leaves them out",
    "interval": "it belongs to a running estimate that scripts read",
    "combine": "--over makes grids",
    "percentiles": "a list of numbers is a matter of scripts",
    "near": "it concerns the comparison of attractors in scripts",
    "special": "it needs a branch, which scripts keep",
    "data": "the command makes it",
    "run": "the command makes it",
}

# Options that are not called like the parameter: one name has one meaning in all commands.
RENAMED = {
    ("find_orbit", "period"): "order",
    ("smoothing_report", "period"): "order",
    ("smoothing_report", "samples"): "samples_per_period",
    ("manifold", "side"): "sides",
    ("homoclinic_points", "side"): "sides",
    ("homoclinic_points", "to_side"): "to_sides",
    ("attractors", "samples"): "starts",
    ("bifurcation_picture", "samples"): "starts",
    ("bifurcation_picture", "completion"): "complete",
    ("bifurcation_picture", "columns"): "values",
    ("attractors", "completion"): "complete",
    ("basins_of_attraction", "samples"): "starts",
    ("erosion_profile", "samples"): "starts",
    ("erosion_profile", "completion"): "complete",
    ("basins_of_attraction", "completion"): "complete",
    ("continue_orbit", "direction"): "way",
    ("measured.low_pass", "cutoff"): "low_pass",
    ("measured.diagram", "unit"): "speed_unit",
    ("posterior", "draws"): "posterior",
}

# Arguments that --over gives.
_RANGES = ("parameter", "values", "region", "over", "between")

_PLOT = "Draw {} into this file. Its suffix says the format: .png, .pdf or .svg."
_SAVE = "Save {} into this netCDF file, which ends in .nc."
_JSON = Own("json", "Print one JSON document, with numbers as numbers, in place of the table.")


class Entry(NamedTuple):
    """What a command is: everything that its verbs do not say."""

    about: str
    run: str  # module of this package and function, such as ``sweeps.diagram``
    verbs: tuple[
        tuple[str, str], ...
    ] = ()  # and their parameters; all of them, or all but ``-name``
    own: tuple[Own, ...] = ()
    defaults: Mapping[str, Any] = {}
    multiple: tuple[str, ...] = ()
    arguments: str = "MODEL [NAME=VALUE...]"
    plot: str = ""  # what --plot draws
    save: str = ""  # what --save saves
    size: tuple[float, float] = (12.0, 8.0)  # of the picture, in cm, between one column and two
    json: bool = True
    example: str = ""  # a command that can be typed, and takes seconds

    def flags(self) -> dict[str, str]:
        """Options of the parameters of all verbs, by the names of the parameters."""
        return {
            name: flag(option) for verb, names in self.verbs for name, option in taken(verb, names)
        }

    def arguments_as_options(self) -> dict[str, str]:
        """What the shell calls the arguments that errors of the verbs may name.

        An argument without an option keeps its name, as a plain word.
        """
        names = (name for verb, _ in self.verbs for name in parameters(verb))
        found = {name: name.replace("_", " ") for name in names}
        found |= {own.name: flag(own.name) for own in self.own}
        own = {each.name for each in self.own}
        if "over" in own:
            found |= dict.fromkeys(_RANGES, "--over")
        if "no_events" in own:
            found["events"] = "--no-events"
        if "contact_range" in own:
            found["contact"] = "--contact-range"
        return found | self.flags()


def taken(verb: str, names: str) -> Iterator[tuple[str, str]]:
    """Parameters of a verb that are options of a command, and the names of these options."""
    words = names.split()
    chosen = [word for word in words if not word.startswith("-")] or [
        name for name in parameters(verb) if name not in LEFT_OUT and f"-{name}" not in words
    ]
    for name in chosen:
        yield name, RENAMED.get((verb, name), name)


class VerbCommand(click.Command):
    """Command whose parameters are made when they are first asked for."""

    def __init__(self, name: str, entry: Entry) -> None:
        self.entry = entry
        super().__init__(
            name,
            callback=self._run,
            help=entry.about,
            short_help=entry.about.split("\n")[0],
            epilog=entry.example,
        )

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Arguments and options."""
        if not self.params:
            self.params = [*_arguments(self.entry.arguments), *self._options()]
        return super().get_params(ctx)

    def make_parser(self, ctx: click.Context) -> Any:
        """Parser of all options."""
        self.get_params(ctx)
        return super().make_parser(ctx)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse; an argument of Python that has another name here is told by that."""
        try:
            if not ctx.resilient_parsing:  # completion looks at lines that are not whole
                _, _, order = self.make_parser(ctx).parse_args(list(args))
                _refuse_repeats(order)
            return super().parse_args(ctx, args)
        except click.MissingParameter as fault:
            if isinstance(fault.param, click.Option):
                name, form = fault.param.opts[0], str(fault.param.metavar)
                said = f"Give it in the form {name} {form}."
                raise click.MissingParameter(said, fault.ctx, fault.param) from None
            raise
        except click.NoSuchOption as fault:
            instead = self._instead(fault.option_name)
            if not instead:
                raise
            said = f"No such option {fault.option_name!r}: {instead}."
            raise click.NoSuchOption(fault.option_name, said, ctx=fault.ctx) from None

    def _instead(self, option: str) -> str:
        """What stands for an argument of Python that is no option under its own name."""
        name = option.lstrip("-").replace("-", "_")
        called = self.entry.flags().get(name)
        if called is not None:
            return f"it is called {called} here, as in all commands"
        if not any(name in parameters(verb) for verb, _ in self.entry.verbs):
            return ""
        return LEFT_OUT.get(name, "")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write arguments, options of the verb, and those of pictures and files apart."""
        last: list[tuple[str, str]] = []
        groups: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": [], "Output": []}
        output = {"plot", "save", "json", "store"}
        output |= {own.name for own in self.entry.own if _is_output(own)}
        for param in self.get_params(ctx):
            record = param.get_help_record(ctx)
            if isinstance(param, click.Argument):
                groups["Arguments"].append((param.make_metavar(ctx), _ARGUMENTS[str(param.name)]))
            elif record is not None and "--help" in param.opts:
                last = [record]
            elif record is not None:
                groups["Output" if param.name in output else "Options"].append(record)
        (groups["Output"] or groups["Options"]).extend(last)
        for title, records in groups.items():
            if records:
                with formatter.section(title):
                    formatter.write_dl(records)

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the example, in one line, so that it can be copied."""
        with formatter.section("Example"):
            formatter.write(f"{'':{formatter.current_indent}}{self.epilog}\n")

    def _options(self) -> Iterator[click.Option]:
        entry, flags, seen = self.entry, self.entry.flags(), set()
        own = [each for each in entry.own if not _is_output(each)]
        yield from (own_option(each) for each in own)
        seen |= {each.name for each in own}
        for verb, names in entry.verbs:
            for name, option in taken(verb, names):
                if option in seen:
                    continue
                seen.add(option)
                found = parameters(verb)[name]
                default = entry.defaults.get(option, found.default)
                several = option in entry.multiple
                yield verb_option(
                    verb, found, option, default=default, multiple=several, flags=flags
                )
        if entry.plot:
            yield own_option(Own("plot", _PLOT.format(entry.plot), "FILE"))
        yield from (own_option(each) for each in entry.own if _is_output(each))
        if entry.save:
            yield own_option(Own("save", _SAVE.format(entry.save), "FILE"))
        if entry.json:
            yield own_option(_JSON)

    def _run(self, **given: Any) -> None:
        module, _, function = self.entry.run.rpartition(".")
        run = getattr(importlib.import_module(f"nonsmooth.cli.{module}"), function)
        context = click.get_current_context()
        unset = (ParameterSource.DEFAULT, ParameterSource.DEFAULT_MAP)
        typed = {name for name in given if context.get_parameter_source(name) not in unset}
        options = self.entry.arguments_as_options()
        with warnings.catch_warnings():
            warnings.simplefilter("always", ResultWarning)
            warnings.showwarning = partial(_tell, options)
            try:
                run(Task(self.entry, given, typed))
            except (OptionError, RunError) as error:
                error.args = (error_in_words_of_shell(str(error), options),)
                raise


def _refuse_repeats(order: Sequence[click.Parameter]) -> None:
    """Refuse an option that takes one value and is given several, of which the last would count."""
    for each, times in Counter(order).items():
        if not isinstance(each, click.Option) or each.multiple or each.is_flag or times == 1:
            continue
        name, form = each.opts[0], str(each.metavar)
        cure = "give it once"
        if "," in form or "..." in form:
            cure += f", with all its values in one list, of the form {name} {form}"
        raise OptionError(f"{name} is given {times} times and counts once; {cure}")


def _tell(
    options: Mapping[str, str], message: Warning | str, category: type[Warning], *_: Any
) -> None:
    """Print a warning as one line, without the place in the source where it was raised.

    Those of arrays and other libraries say nothing of the motion, and are left to scripts.
    """
    if not issubclass(category, ResultWarning | RunWarning):
        return
    said = advice_in_words_of_shell(str(message), options)
    click.echo(f"nonsmooth: {said}", err=True)


_ARGUMENTS = {
    "model": "Name of a ready-made system (nonsmooth models lists them), or a file of your own,"
    " which ends in .toml (nonsmooth models moling --toml prints one to start from).",
    "settings": "Values of parameters, such as b=0.15; a value may be an expression such as pi/2.",
    "files": "CSV files, one for each speed.",
    "healthy": "Records of the healthy machine: CSV files, or netCDF files of indicators over"
    " window, to which a script may have added some.",
    "record": "File of the record: .csv with a column for the times and one for each channel;"
    " a fit takes .nc too.",
    "shaft": "File .npz or .mat with the matrices of a shaft and the names of its coordinates, or"
    " a folder with a file for each matrix.",
    "store": "Folder of a map, which nonsmooth plan --store map.zarr makes; for progress also that"
    " of another command.",
    "file": "File of basins, which nonsmooth basins --save basins.nc writes.",
}


def _is_output(own: Own) -> bool:
    """Whether an option says what is drawn, or where."""
    return own.drawn or own.filmed or own.name == "animate"


class _Model(click.ParamType):
    name = "MODEL"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Ready-made systems, and files."""
        from nonsmooth.models.ready_made import ready_made

        known = [CompletionItem(name) for name in ready_made() if name.startswith(incomplete)]
        return known or [CompletionItem(incomplete, type="file")]


def _arguments(shape: str) -> Iterator[click.Argument]:
    if shape.startswith(("MODEL", "[MODEL]")):
        yield click.Argument(
            ["model"], type=_Model(), required=shape.startswith("MODEL"), metavar=shape.split()[0]
        )
        if "RECORD" in shape:
            yield click.Argument(["record"], metavar="RECORD", type=click.Path())
        if "NAME=VALUE" in shape:
            yield click.Argument(["settings"], nargs=-1, metavar="[NAME=VALUE...]")
    elif shape.endswith("..."):
        name = "files" if shape == "FILE..." else shape.removesuffix("...").lower()
        yield click.Argument([name], nargs=-1, required=True, metavar=shape, type=click.Path())
    elif shape == "SHAFT":
        yield click.Argument(["shaft"], metavar=shape, type=click.Path())
    elif shape == "STORE":
        yield click.Argument(["store"], metavar=shape, type=click.Path())
    elif shape == "FILE.csv":
        yield click.Argument(["record"], metavar=shape, type=click.Path())
    else:
        yield click.Argument(["file"], metavar=shape, type=click.Path())


class Task:
    """One run of a command: what was given, and what every command does with a result."""

    def __init__(self, entry: Entry, given: Mapping[str, Any], typed: set[str]) -> None:
        from nonsmooth.files import check_target

        self.entry, self.given, self.typed = entry, given, typed
        # functions of `nonsmooth.plot` with what they are given, one below the other
        self._panels: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = []
        self._animation: Any = None
        self.plot = _path(given.get("plot"))
        self.film = _path(given.get("animate"))
        self.save = _path(given.get("save"))
        # files that could not be written are refused before a long run and not after it
        if self.plot is not None:
            check_target(self.plot, PICTURES)
        if self.save is not None:
            check_target(self.save, (".nc",))
        if self.film is not None:
            from nonsmooth.plot.film_files import check_film

            check_film(self.film)
        self._check_targets()

    def _check_targets(self) -> None:
        """Refuse options of pictures and films that are drawn nowhere."""
        idle: dict[str, list[str]] = {}
        for each in self.entry.own:
            done = (each.drawn and self.plot) or (each.filmed and self.film)
            if each.name in self.typed and (each.drawn or each.filmed) and not done:
                file = "--plot picture.png" if each.drawn else "--animate film.mp4"
                idle.setdefault(file, []).append(flag(each.name))
        if idle:
            file, flags = next(iter(idle.items()))
            raise OptionError(
                f"{' and '.join(flags)}: this is drawn into a file: name it, such as {file}"
            )

    def __getitem__(self, name: str) -> Any:
        return self.given[name]

    def is_given(self, name: str) -> bool:
        """Whether an option stands in the command, in place of its default."""
        return name in self.typed

    @cached_property
    def system(self) -> System:
        """System of the arguments."""
        initial = self.entry.flags().get("initial", "")
        return build_system(self["model"], self._values, initial)

    @property
    def _values(self) -> dict[str, str]:
        """Texts of the values of parameters."""
        apart = "put blanks between several, as in omega=1 zeta=0.1"
        return settings(self["settings"], "NAME=VALUE", "name=value, such as omega=0.8", apart)

    def refuse_fixed(self, changed: Iterable[str], option: str) -> None:
        """Refuse a value in the command of a parameter that an option changes anyway."""
        refuse_fixed(self["model"], self._values, changed, option)

    def options(self, verb: str, *without: str) -> dict[str, Any]:
        """Keyword arguments of a verb: what its options are given."""
        names = dict(self.entry.verbs)[verb]
        found = {name: self.given[option] for name, option in taken(verb, names)}
        for name in ("word", "contact"):
            if isinstance(found.get(name), list):
                found[name] = whole_names(found[name], self.system.mode_names)
        return {name: value for name, value in found.items() if name not in without}

    def picture(self, function: str, data: Any, *arguments: Any, **options: Any) -> None:
        """Choose what --plot draws: a function of `nonsmooth.plot`, and what it is given.

        A further choice is drawn below the first one, over the same axis.
        """
        self._panels.append((function, (data, *arguments), options))

    def animation(self, run: xr.Dataset, **options: Any) -> None:
        """Make the film for --animate; what is wrong with it is told before the report."""
        from nonsmooth import plot

        self._animation = plot.animate(run, **options)

    def finish(
        self, result: xr.Dataset | None, report: Report, *, kept: str | None = None, code: int = 0
    ) -> None:
        """Print the report, save the result, draw the picture and leave with a code.

        `kept` is a file that has the result already.
        """
        if code == INTERRUPTED and result is not None:
            self._add_interruption(report, str(result.attrs["message"]))
        options = self.entry.arguments_as_options()
        report.reword(lambda text: advice_in_words_of_shell(text, options))
        if self.given.get("json"):
            report.print_json()
        else:
            report.print()
        drawn = code != INTERRUPTED or result is None or all(result.sizes.values())
        pictured = self.plot is not None and bool(self._panels) and drawn
        if code == INTERRUPTED:
            self._announce(saved=result is not None, drawn=pictured)
        if self.save is not None and result is not None:
            from nonsmooth.files import replacing

            with replacing(self.save) as draft:
                result.to_netcdf(draft, engine="h5netcdf")
            kept = str(self.save)
        if kept is not None:
            self.say(f"saved {kept}")
        if self.plot is not None and pictured:
            self._draw(self.plot)
        if self.film is not None and self._animation is not None:
            from nonsmooth import plot

            plot.save_animation(self._animation, self.film)
            self.say(f"drawn {self.film}")
        if code:
            raise click.exceptions.Exit(code)

    def _announce(self, *, saved: bool, drawn: bool) -> None:
        """Say what follows an interruption: who pressed Ctrl-C waits for the prompt."""
        filmed = self.film is not None and self._animation is not None
        left = [str(self.save)] * (self.save is not None and saved)
        left += [str(self.plot)] * drawn + [str(self.film)] * filmed
        if left:
            files = " and ".join(left)
            click.echo(
                f"nonsmooth: interrupted; what is done goes into {files}; Ctrl-C again leaves"
                f" {'it' if len(left) == 1 else 'them'} unwritten",
                err=True,
            )

    def _draw(self, file: Path) -> None:
        from nonsmooth import plot

        width, height = self.entry.size
        rows = len(self._panels)
        height *= 0.5 * (1 + rows)  # a further panel has half the height
        figure, axes = plot.print_figure(rows, width=width, height=height, share_x=rows > 1)
        for (function, arguments, options), ax in zip(self._panels, axes, strict=True):
            getattr(plot, function)(*arguments, ax=ax, **options)
        for ax in axes[:-1]:
            ax.set_xlabel("")
        plot.save_figure(figure, file)
        self.say(f"drawn {file}")

    def _add_interruption(self, report: Report, message: str) -> None:
        """Say what is done, and how to go on where finished parts are kept."""
        if all(text != message for _, text in report.lines):
            report.add("message", message)
        if "store" in self.given:
            kept = "name a folder by --store, in which finished parts are kept"
            report.add("to go on", "repeat the command" if self["store"] else kept)

    def say(self, text: str) -> None:
        """Print a line; beside a JSON document it goes to the stream of messages."""
        click.echo(text, err=bool(self.given.get("json")))

    def by_status(self, result: xr.Dataset) -> int:
        """Exit code of a run that may not have come to its end."""
        status = result.attrs["status"]
        if status == "interrupted":
            return INTERRUPTED
        return 0 if status in ("completed", "stopped") else ENDED_EARLY

    def by_message(self, result: xr.Dataset, complete: bool | None = None) -> int:
        """Exit code of a result of many runs, all of which should be complete."""
        if result.attrs["status"] == "interrupted":
            return INTERRUPTED
        done = result.attrs["message"] == "completed" if complete is None else complete
        return 0 if done else ENDED_EARLY


def _path(text: str | None) -> Path | None:
    return None if text is None else Path(text)
