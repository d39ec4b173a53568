"""The commands: which verbs they call, and what those do not say.

Everything else about an option is in the signature and the docstring of its verb.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.cli.arguments import initial_state, time_range
from nonsmooth.cli.command import Entry
from nonsmooth.cli.machine_table import MACHINES
from nonsmooth.cli.options import Own

__all__ = ["TABLE"]


def _over(text: str, metavar: str = "NAME=A:B:N", **more: Any) -> Own:
    return Own("over", text, metavar, **more)


def _draw(text: str, metavar: str = "x,v") -> Own:
    return Own("draw", text, metavar, drawn=True)


def _colour(usual: str) -> Own:
    text = "What the colours of the picture tell."
    return Own("colour", text, "NAME", usual, (usual, "period"), drawn=True)


_PARAMETER = "Parameter, its first value, its last value and how many values."
_PAIR = _draw("Draw the second variable over the first; the first two states by default.")
_MODES = Own("modes", "Colour the points by mode.", drawn=True)
_ON_SECTION = Own(
    "section",
    "Take points on this section in place of one per period: where an expression is zero, such as"
    " x-0.5, or at an event, such as impact. What is said of periods then counts these points.",
    "EXPRESSION",
)
_STROBES = ("StroboscopicMap", "phase period every")
_SECTION = ("PoincareMap", "section direction side")


TABLE = {
    "simulate": Entry(
        "Simulate a motion, and print how it ended, its events and its end state.\n\nWithout"
        " --periods and --t-end the motion takes 20 periods. Where there is no period it takes"
        " about 50 times the shortest natural period or time constant, which may be a part of one"
        " stick-slip cycle: give --t-end.",
        "runs.simulate",
        (("simulate", ""),),
        (
            Own(
                "no_events",
                "Count events, and keep no log of them: a run of any length then takes no more"
                " memory than its samples.",
            ),
            Own(
                "portrait",
                "Draw a phase portrait, the second variable over the first, in the colours of"
                " the modes, in place of a time history.",
                "x,v",
                drawn=True,
                filmed=True,
            ),
            Own("orbit", "Draw the orbit of two coordinates instead.", "x,y", drawn=True),
            Own("modes", "Colour the modes behind the time history.", drawn=True),
            _draw("States and outputs of the time history.", "NAME[,NAME...]"),
            Own("from", "Draw from this period on.", "NUMBER", drawn=True, filmed=True),
            Own(
                "time_range",
                "Draw between these two times.",
                "A,B",
                convert=time_range,
                drawn=True,
                filmed=True,
            ),
            Own(
                "animate",
                "Write a film of the machine and its phase portrait into this file, which ends in"
                " .mp4, .gif or .html. --portrait names the variables of the portrait, --from and"
                " --time-range the times.",
                "FILE",
            ),
            Own(
                "slow_down",
                "Seconds of the film for a period, or for a unit of time without a period; 4 by"
                " default, or less for many periods.",
                "NUMBER",
                filmed=True,
            ),
        ),
        plot="a time history",
        save="the run",
        size=(12.0, 7.5),
        example="nonsmooth simulate soft_impact omega=0.85"
        " --initial x=0.1 --periods 50 --plot run.png",
    ),
    "lyapunov": Entry(
        "Find the Lyapunov exponents of a motion, with standard errors.",
        "runs.lyapunov",
        (("lyapunov_spectrum", ""),),
        plot="how the exponents settle",
        save="the result",
        size=(12.0, 7.5),
        example="nonsmooth lyapunov soft_impact a=0.9 --record 200",
    ),
    "spectrum": Entry(
        "Find the amplitudes of a variable over frequency.\n\nTwo variables are the coordinates of"
        " a motion in a plane, whose forward and backward whirl are told apart.",
        "runs.spectrum",
        (("simulate", "initial mode"), ("power_spectrum", "window segments")),
        (
            Own(
                "variable",
                "State or output to analyse, the first state by default; or two coordinates.",
                "x[,y]",
            ),
            Own(
                "transient",
                "Length left out at the beginning, in periods, or in units of time without a"
                " period. It is 0 or more.",
                "NUMBER",
                200.0,
            ),
            Own(
                "record",
                "Length of the record, in periods, or in units of time without a period. It is"
                " more than 0.",
                "NUMBER",
                200.0,
            ),
            Own(
                "samples_per_period",
                "Samples per period, or per unit of time without a period; 2 or more.",
                "N",
                64,
            ),
        ),
        plot="the amplitudes",
        save="the result",
        size=(12.0, 7.5),
        example="nonsmooth spectrum soft_impact --variable x --record 100 --plot spectrum.svg",
    ),
    "waterfall": Entry(
        "Find the spectra of settled motions for many values of a parameter.",
        "sweeps.waterfall",
        (("waterfall", ""),),
        (
            _over(_PARAMETER, required=True),
            Own(
                "variable",
                "State or output to analyse, the first state by default; or two coordinates of a"
                " motion in a plane.",
                "x[,y]",
            ),
            Own(
                "picture",
                "Draw lines one below the other, or a map in colours.",
                "NAME",
                "cascade",
                ("cascade", "map"),
                drawn=True,
            ),
            Own(
                "axis",
                "What the horizontal axis of the picture shows.",
                "NAME",
                "frequency",
                ("frequency", "harmonic"),
                drawn=True,
            ),
        ),
        plot="the spectra",
        save="the result",
        size=(12.0, 9.0),
        example="nonsmooth waterfall soft_impact --over omega=0.7:0.9:5 --plot waterfall.png",
    ),
    "contacts": Entry(
        "Count the contacts of settled motions, and tell how long they last and how hard they are.",
        "sweeps.contacts",
        (("contact_statistics", ""),),
        (
            _over(_PARAMETER + " Without it there is one motion."),
            _draw("What to draw; the first name of --of by default, or else contacts.", "NAME"),
        ),
        plot="a quantity over the parameter",
        save="the result",
        example="nonsmooth contacts soft_impact --over omega=0.7:0.9:9 --of stop_force",
    ),
    "zero-one": Entry(
        "Test for chaos with the 0-1 test: K is near 1 for chaotic, near 0 for regular motion.",
        "runs.zero_one",
        (
            ("stroboscopic_map", "initial transient record period phase mode tolerance"),
            ("zero_one_test", "every frequencies seed"),
        ),
        (Own("variable", "State or output to test, the first state by default.", "x"),),
        {"transient": 200, "record": 2000},
        plot="the translation variables",
        save="the result",
        size=(10.0, 9.0),
        example="nonsmooth zero-one soft_impact --record 1000",
    ),
    "section": Entry(
        "Take points of a motion where an expression is zero, or at an event.",
        "runs.section",
        (("poincare_section", ""),),
        (_PAIR, _MODES),
        plot="the points",
        save="the points",
        size=(10.0, 8.0),
        example="nonsmooth section soft_impact --section impact --record 50",
    ),
    "strobe": Entry(
        "Take points of a motion, one per period of the forcing.",
        "runs.strobe",
        (("stroboscopic_map", ""),),
        (_PAIR, _MODES),
        {"transient": 200},
        plot="the points",
        save="the points",
        size=(10.0, 8.0),
        example="nonsmooth strobe soft_impact --record 100 --plot points.png",
    ),
    "diagram": Entry(
        "Compute a bifurcation diagram: settled motions for many values of a parameter.",
        "sweeps.diagram",
        (("bifurcation_diagram", ""), ("PoincareMap", "section direction")),
        (
            _over(_PARAMETER, required=True),
            _ON_SECTION,
            _draw("What to draw, the first state by default.", "NAME"),
            _colour("initial"),
        ),
        multiple=("initial",),
        plot="the diagram",
        save="the diagram",
        example="nonsmooth diagram soft_impact --over omega=0.7:0.9:41 --plot diagram.png",
    ),
    "regime": Entry(
        "Find what one motion settles to, a period or chaos, and on what evidence.",
        "regimes.regime",
        (("regime", ""),),
        save="the result",
        example="nonsmooth regime soft_impact omega=0.8",
    ),
    "regimes": Entry(
        "Find what motions settle to, a period or chaos, for many values of two parameters.",
        "regimes.regimes",
        (("regime_map", ""),),
        (_over(_PARAMETER + " Give it twice.", required=True, multiple=True),),
        plot="the map",
        save="the map",
        example="nonsmooth regimes soft_impact"
        " --over omega=0.7:0.9:5 --over a=0.5:0.7:5 --plot regimes.png",
    ),
    "plan": Entry(
        "Plan a map of regimes of any size, which any number of workers compute together.",
        "cluster.plan",
        (("cluster.plan_map", ""),),
        (_over(_PARAMETER + " Give it twice.", required=True, multiple=True),),
        example="nonsmooth plan soft_impact"
        " --over omega=0.7:0.9:40 --over a=0.5:0.7:30 --store map.zarr",
    ),
    "forecast": Entry(
        "Tell how long the rest of a planned map will take here, from a sample of it.",
        "cluster.forecast",
        (("cluster.forecast", "sample threads seed"),),
        arguments="STORE",
        example="nonsmooth forecast map.zarr --sample 32",
    ),
    "work": Entry(
        "Compute what is missing of a planned map, beside any number of other workers.",
        "cluster.work",
        (("cluster.work", "threads max_seconds retry patience"),),
        (
            Own("tiles", "Numbers of the tiles to look after, from 0 on; all by default.", "K,K"),
            Own(
                "part",
                "Look after one of so many equal parts of the tiles, such as 3/16, where workers"
                " should not depend on claims.",
                "K/N",
            ),
        ),
        arguments="STORE",
        example="nonsmooth work map.zarr --max-seconds 3500",
    ),
    "progress": Entry(
        "Tell how far a planned map is, or the work of a command with --store.",
        "cluster.progress",
        arguments="STORE",
        example="nonsmooth progress map.zarr",
    ),
    "orbit": Entry(
        "Find a periodic orbit, stable or not, with its multipliers.",
        "orbits.orbit",
        (("find_orbit", ""),),
        (
            _PAIR,
            Own("history", "Draw these variables over time instead.", "x,v", drawn=True),
            Own("multipliers", "Draw the multipliers instead.", drawn=True),
            Own("less_drift", "Draw a drifting state less its mean motion.", drawn=True),
        ),
        plot="the orbit",
        save="the orbit",
        size=(10.0, 8.0),
        example="nonsmooth orbit soft_impact omega=0.8 --plot orbit.png",
    ),
    "manifold": Entry(
        "Follow the unstable or the stable manifold of a saddle orbit, as curves of strobes.\n\n"
        "The orbit is found first, as nonsmooth orbit does.",
        "orbits.manifold",
        (
            ("find_orbit", "initial period word transient phase mode tolerance"),
            ("manifold", "which length side largest_step smallest_step angle accuracy longest"),
        ),
        (_PAIR,),
        plot="the curves",
        save="the curves",
        size=(10.0, 8.0),
        example="nonsmooth manifold duffing gamma=0.2 --initial x=-0.08 --plot manifold.png",
    ),
    "homoclinic": Entry(
        "Find where the manifolds of a saddle orbit cross, or over a parameter, where they touch."
        "\n\nThe orbit is found first, as nonsmooth orbit does.",
        "orbits.crossings",
        (
            ("find_orbit", "initial period word transient phase mode tolerance"),
            ("homoclinic_points", "length side to_side largest_step smallest_step angle accuracy"),
        ),
        (
            Own(
                "to",
                "State near a second saddle, whose stable manifold is taken; without it the"
                " first one's.",
                "x=0.1,v=0",
                convert=initial_state,
            ),
            _over("Look between these two values of a parameter for a tangency.", "NAME=A:B"),
        ),
        plot="the crossings",
        save="the result",
        size=(10.0, 8.0),
        example="nonsmooth homoclinic duffing gamma=0.3 --initial x=-0.08 --length 6",
    ),
    "continue": Entry(
        "Follow a periodic orbit over a parameter, stable or not, through folds and grazing.\n\n"
        "The orbit is found first at the value that the parameter has.",
        "orbits.follow",
        (
            ("find_orbit", ""),
            ("continue_orbit", "direction steps step largest_step smallest_step inadmissible"),
        ),
        (
            _over("Parameter, with its least and largest value.", "NAME=A:B", required=True),
            _draw("What to draw; a drift per unit time by default, or else a state.", "NAME"),
            Own(
                "diagram",
                "Draw over this diagram, which nonsmooth diagram --save diagram.nc writes.",
                "FILE",
                drawn=True,
            ),
            Own("multipliers", "Draw the paths of the multipliers instead.", drawn=True),
            Own("criticality", "Tell of each special point what begins there."),
        ),
        plot="the branch",
        save="the branch",
        size=(12.0, 9.0),
        example="nonsmooth continue soft_impact a=0.4 --over a=0.3:0.5 --plot branch.png",
    ),
    "smoothing": Entry(
        "Compare a system with the same one where smooth functions take the place of switches.\n\n"
        "Without --periods and --t-end the motion takes 20 periods.",
        "smoothing.smoothing",
        (("smoothing_report", "-between"),),
        (
            Own(
                "toml",
                "Print the system smoothed by one width as TOML, and compare nothing. The width"
                " may be the name of a new parameter.",
            ),
            _over(
                "Of a parameter: follow the orbit in this range. Of states: look for attractors"
                " in this range. You may give it several times.",
                "NAME=A:B",
                multiple=True,
            ),
            Own(
                "draw",
                "Quantity to draw over the width.",
                "NAME",
                "error",
                ("error", "stick_time_error", "creep", "special_shift", "extra_width"),
                drawn=True,
            ),
        ),
        plot="a quantity",
        save="the report",
        size=(10.0, 8.0),
        example="nonsmooth smoothing friction_oscillator --epsilons 0.1,0.01 --periods 3",
    ),
    "ensemble": Entry(
        "Run every combination of initial states and parameter values, and keep its strobes.",
        "sweeps.ensemble",
        (("ensemble", ""),),
        (
            _over(
                "State or parameter, its first value, its last value and how many values. You may"
                " give it several times.",
                required=True,
                multiple=True,
            ),
        ),
        save="the result",
        example="nonsmooth ensemble soft_impact"
        " --over x=-1:1:5 --over omega=0.7:0.9:3 --save runs.nc",
    ),
    "picture": Entry(
        "Draw up all that a system does over a parameter: attractors, shares of basins, branches.",
        "sweeps.picture",
        (("bifurcation_picture", "-between"), ("StroboscopicMap", "phase")),
        (
            _over(
                "The parameter with its least and largest value; and each state from whose range"
                " starts are drawn.",
                "NAME=A:B",
                required=True,
                multiple=True,
            ),
            _draw("State to draw, the first one by default.", "NAME"),
        ),
        plot="attractors, branches and shares",
        save="the result",
        size=(16.0, 11.0),
        example="nonsmooth picture soft_impact omega=0.8 --over a=0.3:0.5 --over x=-2:2"
        " --over v=-2:2 --values 11 --starts 10",
    ),
    "attractors": Entry(
        "Find the attractors of a region from random initial states.",
        "basins.attractors",
        (("attractors", ""), _STROBES, _SECTION),
        (
            _ON_SECTION,
            _over(
                "State, and the range of its random values; for each such state.",
                "x=A:B",
                required=True,
                multiple=True,
            ),
            _draw("Draw the second state over the first."),
        ),
        plot="the points",
        save="the result",
        size=(12.0, 9.0),
        example="nonsmooth attractors soft_impact --over x=-1:1 --over v=-1:1 --starts 20",
    ),
    "basins": Entry(
        "Find which initial states of a grid lead to which attractor.",
        "basins.basins",
        (("basins_of_attraction", ""), _STROBES, _SECTION),
        (
            _ON_SECTION,
            _over(
                "State, its first value, its last value and how many values; for two states or"
                " more.",
                "x=A:B:N",
                required=True,
                multiple=True,
            ),
            _colour("attractor"),
        ),
        plot="the basins",
        save="the result",
        size=(12.0, 10.0),
        example="nonsmooth basins soft_impact"
        " --over x=-1:1:20 --over v=-1:1:20 --starts 20 --save basins.nc",
    ),
    "edge": Entry(
        "Follow the border between two basins to the saddle on it.",
        "edges.edge",
        (
            (
                "edge_state",
                "start_a start_b iterates points narrow wide longest record mode tolerance",
            ),
            _STROBES,
            _SECTION,
        ),
        (_ON_SECTION, _PAIR),
        plot="the track along the border and the saddle",
        save="the result",
        size=(10.0, 8.0),
        example="nonsmooth edge gear_pair Omega=0.5 --start-a x=-0.2 --start-b x=1.2",
    ),
    "erosion": Entry(
        "Measure how basins shrink over a parameter.\n\nThe command prints the distance of each"
        " attractor from the border of its basin, the share of the region in the basin, and the"
        " radius of the largest ball in it.",
        "edges.erosion",
        (("erosion_profile", ""), _STROBES, _SECTION),
        (
            _ON_SECTION,
            _over(
                "The parameter, and each of two states or more, with the first value, the last"
                " value and how many values.",
                required=True,
                multiple=True,
            ),
            Own(
                "draw",
                "What to draw: the distance of each attractor from the border, the share of the"
                " region, or the largest ball.",
                "NAME",
                "local",
                ("local", "global", "factor"),
                drawn=True,
            ),
            Own("relative", "Draw each curve beside its largest value.", drawn=True),
        ),
        plot="the profile",
        save="the result",
        size=(12.0, 8.0),
        example="nonsmooth erosion gear_pair --over Omega=0.4:0.6:3 --over x=-3:4:30"
        " --over v=-2:2:30 --starts 40",
    ),
    "measures": Entry(
        "Measure how predictable the outcomes of saved basins are.\n\nThe command prints the"
        " uncertainty exponent, the entropy of the basins, the share of each outcome, and whether"
        " three or more basins have one boundary.",
        "basins.measures",
        (("uncertainty_exponent", "between"), ("basin_entropy", "box"), ("wada_test", "fatten")),
        arguments="FILE.nc",
        plot="the uncertain part over the distance",
        size=(10.0, 8.0),
        example="nonsmooth measures basins.nc",
    ),
    **MACHINES,
    "models": Entry(
        "List the ready-made systems, or print the equations of one.",
        "models.models",
        own=(Own("toml", "Print the system as TOML, to be changed and simulated."),),
        arguments="[MODEL]",
        example="nonsmooth models moling",
    ),
    "explain": Entry(
        "Print states, natural motions, forcing and exits of a system.",
        "models.explain",
        json=False,
        example="nonsmooth explain moling b=0.2",
    ),
    "explore": Entry(
        "Open a page in the browser, in which a system moves while you change it.\n\nWithout MODEL"
        " the page opens with the ground mole. It is served on this machine, for this machine,"
        " until you press Ctrl-C.",
        "models.explore",
        (("explore", "link port work_limit"),),
        (
            Own(
                "allow_origin",
                "Let pages of this host use the server, such as lecture.example.org:5006, and"
                " listen on all addresses of the machine. Everyone who reaches it can then have it"
                " compute, without a password. You may give it several times.",
                "HOST:PORT",
                multiple=True,
            ),
            Own("no_browser", "Serve the page, and do not open it."),
        ),
        arguments="[MODEL] [NAME=VALUE...]",
        json=False,
        example="nonsmooth explore moling b=0.12",
    ),
}  # fmt: skip
