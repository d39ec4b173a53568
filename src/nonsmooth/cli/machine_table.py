"""The commands for machines: measured records, fits to them, and shafts by their matrices.

They stand in the table of all commands in the order in which they stand here.
"""

from __future__ import annotations

from nonsmooth.cli.arguments import names
from nonsmooth.cli.command import Entry
from nonsmooth.cli.options import Own
from nonsmooth.cli.structures import speed_range

__all__ = ["MACHINES"]


def _draw(text: str, metavar: str) -> Own:
    return Own("draw", text, metavar, drawn=True)


def _columns(what: str, more: str = "", *, required: bool = True) -> Own:
    text = f"{what} and their columns; a name alone is that of its column.{more}"
    return Own("columns", text, "x=CH1,y=CH2", required=required)


_ACCEPT = Own("accept_flaws", "Leave with the exit code 0 also where a record has flaws.")

MACHINES = {
    "fit": Entry(
        "Fit parameters of a system to records, and print 95 % intervals.\n\nFlaws of a record are"
        " told one by one, flawed and missing samples are left out, and the exit code is then 3.",
        "fitting.fit",
        (
            ("fit", "initial shift private form cycle segments hold_back starts loss bootstrap"
             " tolerance seed"),
            ("measured.read_csv", "time sample_rate time_range delimiter decimal"),
            ("measured.check", "false_alarms mains leave_out"),
            ("posterior", "draws store seed"),
        ),
        (
            Own("free", "Parameter to find, with its least and its largest value. You may give it"
                " several times.", "NAME=A:B", multiple=True, required=True),
            Own("observe", "What a channel shows: an expression of states, outputs and rates, or"
                " an event for the instants of --events. Without it a channel shows the state, the"
                " output or the event of its own name. You may give it several times.",
                "NAME=EXPRESSION", multiple=True),
            _columns("Names of the channels", " Without it a channel of --observe is the column of"
                     " its name.", required=False),
            Own("events", "Channel of the instants of events, picked from the record, and a CSV"
                " file of which they are the first column, in s, or in ms or us where its header"
                " says so. You may give it several times.", "NAME=FILE", multiple=True),
            _ACCEPT,
            Own("more", "A further record of the same machine with its name; RECORD has the name of"
                " its file, without the ending. You may give it several times.", "NAME=FILE",
                multiple=True),
            Own("by_record", "Value of a parameter that is known and differs from record to record."
                " You may give it several times.", "RECORD.NAME=VALUE", multiple=True),
            *(
                Own(name, f"{text} It is a number, a range or free. You may give it several times.",
                    "NAME=VALUE", multiple=True)
                for name, text in (
                    ("gain", "Factor of a channel, with a range such as 0.9:1.1."),
                    ("channel_offset", "What a channel adds to its quantity."),
                    ("delay", "Time by which a channel is late, never free."),
                    ("noise", "Standard deviation of the noise of a channel; without it, free."),
                )
            ),
            Own("draw", "What the picture shows: samples with the residuals, profiles of the"
                " likelihood, pairs of parameters, or spectra.", "NAME", default="fit",
                choices=("fit", "profiles", "corner", "spectra"), drawn=True),
            Own("channel", "Channel of the picture of samples or of spectra, the first one by"
                " default.", "x", drawn=True),
        ),
        defaults={"posterior": None},
        arguments="MODEL RECORD [NAME=VALUE...]",
        plot="the fit",
        save="the result",
        size=(12.0, 8.0),
        example="nonsmooth fit soft_impact record.csv --free beta=15:45 --observe x=x",
    ),
    "measured": Entry(
        "Read a measured motion with one mark per revolution, and take its section.\n\nSeveral"
        " files give a diagram over the speed. Without marks the command gives the motion itself,"
        " filtered, integrated or differentiated. Flaws of a record are told one by one, and the"
        " exit code is then 3.",
        "measured.measured",
        (
            (
                "measured.read_csv",
                "mark time sample_rate time_range edge threshold hysteresis bad_marks delimiter"
                " decimal",
            ),
            ("measured.Channel", "sensitivity offset units"),
            ("measured.check", "false_alarms mains leave_out"),
            ("measured.dimensionless", "length natural_frequency"),
            ("measured.velocities", "highest bias"),
            ("measured.low_pass", "cutoff"),
            ("measured.displacements", "lowest"),
            ("measured.section", "transient phase"),
            ("measured.diagram", "unit"),
        ),
        (
            _columns("Names of the displacements"),
            _ACCEPT,
            Own("length", "Unit of length, such as the gap, for a record without dimensions.",
                "NUMBER"),
            Own("natural_frequency", "Natural frequency in rad/s, which goes with --length.",
                "NUMBER"),
            Own("low_pass", "Cut-off frequency of a filter without delay, before all else, in Hz.",
                "NUMBER"),
            Own(
                "lowest",
                "Lowest frequency that is kept, in Hz. The columns are then accelerations, and are"
                " integrated twice.",
                "NUMBER",
            ),
            _draw("Variables to draw: one of a diagram, one or two of a record.", "x,vx"),
        ),
        arguments="FILE...",
        plot="the record, the section or the diagram",
        save="the record, the section or the diagram",
        size=(10.0, 8.0),
        example="nonsmooth measured speed_1.csv --columns x=CH1,y=CH2 --mark KEY",
    ),
    "check": Entry(
        "Check a measured record: frozen, clipped and drifting channels, spikes, hum, gaps, marks."
        "\n\nEach flaw is told with its channel and its place. The exit code is 0 for a record"
        " without flaws and 3 for one with some. What other commands refuse, such as missing"
        " samples, is told here.",
        "records.check",
        (
            (
                "measured.read_csv",
                "mark time sample_rate time_range edge threshold hysteresis delimiter decimal",
            ),
            ("measured.Channel", "sensitivity offset units"),
            ("measured.check", "false_alarms mains leave_out"),
        ),
        (
            _columns("Names of the channels"),
            _ACCEPT,
            _draw("Channel to draw; the first one with a flaw by default.", "NAME"),
        ),
        arguments="FILE.csv",
        plot="a channel with its flaws",
        save="the findings and the masks",
        size=(14.0, 7.0),
        example="nonsmooth check run.csv --columns x=CH1,y=CH2 --mark KEY --plot quality.png",
    ),
    "campbell": Entry(
        "Follow the natural frequencies of a shaft over its speed, and find its critical speeds."
        "\n\nThe matrices are called mass and stiffness and, if there are any, damping and"
        " gyroscopic; or M, K, C and G. Names of coordinates are a node and a direction, such as"
        " 3x: from them the sense of whirl is told. Bearings are constant here, as part of"
        " stiffness and damping.",
        "structures.campbell",
        (("structures.campbell", "count harmonics"),),
        (
            Own("speeds", "First speed, last speed and how many, in rad/s.", "A:B:N",
                required=True, convert=speed_range),
            Own("rpm", "Speeds are in revolutions per minute, and frequencies drawn in Hz."),
            Own("units", "Units of the matrices where they are not in SI, such as mm,N,kg,s.",
                "UNIT"),
        ),
        arguments="SHAFT",
        plot="the Campbell diagram",
        save="the diagram and the critical speeds",
        example="nonsmooth campbell shaft.npz --speeds 0:600:61 --plot campbell.png",
    ),
    "alarm": Entry(
        "Set an alarm by records of a healthy machine, for a stated rate of false alarms, and judge"
        " watched records by it.\n\nEach record is cut into windows of whole periods, each of which"
        " has indicators: harmonics, subharmonics, scatter of strobes, share of time in contact."
        " The exit code does not depend on alarms; a script reads them from --json.",
        "alarms.alarm",
        (
            (
                "measured.read_csv",
                "mark time sample_rate time_range edge threshold hysteresis bad_marks delimiter"
                " decimal",
            ),
            ("measured.Channel", "sensitivity offset units"),
            ("measured.check", "false_alarms mains leave_out"),
            ("measured.indicators", "periods period most_period most_flawed"),
            ("measured.alarm", "rate training needed among"),
        ),
        (
            _columns("Names of the channels", required=False),
            Own("watched", "Record to be judged. You may give it several times, in order of time.",
                "FILE", multiple=True),
            Own("contact_range", "Channel that shows a contact, with its least and its largest"
                " value while there is one; an end may be left out, as in x=5: for 5 and more. You"
                " may give it several times.", "NAME=A:B", multiple=True),
            Own("indicators", "Indicators that count, such as x_harmonic_2; all by default.",
                "NAME[,NAME...]", convert=names),
            _ACCEPT,
        ),
        arguments="HEALTHY...",
        plot="the scores of watched windows with the threshold",
        save="the alarm",
        size=(14.0, 8.0),
        example="nonsmooth alarm monday.csv tuesday.csv --watched today.csv --columns a=CH1"
        " --mark KEY --rate 0.05 --plot alarm.png",
    ),
}  # fmt: skip
