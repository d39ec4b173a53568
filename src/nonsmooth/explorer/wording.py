"""Messages of the library in the words of the page: fields of the page for options of verbs."""

from __future__ import annotations

import re

__all__ = ["counted", "in_words_of_page", "of_field", "sentence_of"]

# what stands on the page for a field of a view or an option of a verb
_FIELDS = {
    "leave_out": "leave out",
    "length": "show",
    "between": "from and to",
    "initial": "the start",
    "transient": "leave out",
    "periods": "show",
    "t_end": "show",
    "section": "at",
}
# advice for a program, and what a visitor can do instead
_ADVICE = {
    "; take one of its points instead, as in run.isel(time=-1)": "",
    "give initial= nearer to it, transient= for a motion that has settled, another period=, or"
    " word= for the modes that it visits": "start nearer to it, or leave out more of the motion, so"
    " that it has settled",
    "; if the point is not meant to be reached, add an exit before it, such as"
    " Exit('x - 1e-9', to='stop')": "; an exit before that point would end the motion in order",
    "or give transient=": "or leave out more of the motion",
    "follow a branch with continue_orbit, which passes such points": "press Orbit for another value"
    " nearby, from where the branch passes such points",
    "the run has reached max_seconds= or max_events=; all until then is kept. For more give larger"
    " limits, or go on in Python by simulate(system, run, ...) with the result as the start": "the"
    " motion has taken the work that a page gives to one; for more, copy the script",
    ", which a larger longest= or regime tells": "",
    "; take its StroboscopicMap": "; leave the field 'at' empty, or choose the picture Section",
}
_PARAMETER = re.compile(r"parameters\[['\"](\w+)['\"]\]")
_OF_FIELD = re.compile(r"^([a-z_]+)(?= = |: )")
_VERB = re.compile(
    r"^(simulate|find_orbit|continue_orbit|bifurcation_diagram|basins_of_attraction"
    r"|poincare_section): "
)
_CARET = re.compile(r"\n[^\n]*\n *\^$")  # of a text that stands in its field already
_OPTION = re.compile(r"\b([a-z_]+)=(?=[\s,;.)]|$)")


def in_words_of_page(message: str) -> str:
    """A message as a visitor reads it, who sees fields of the page and no options of verbs."""
    for advice, instead in _ADVICE.items():
        message = message.replace(advice, instead)
    message = _PARAMETER.sub(r"\1", _CARET.sub("", _VERB.sub("", message)))
    return _OPTION.sub(lambda found: _FIELDS.get(found[1], found[1].replace("_", " ")), message)


def of_field(message: str) -> str:
    """A message about a typed field, which begins with the name that the page has for it."""
    return _OF_FIELD.sub(
        lambda found: _FIELDS.get(found[1], found[1].replace("_", " ")), in_words_of_page(message)
    )


def counted(number: int, what: str) -> str:
    """A number of things, as ``1 event`` and ``2 events``."""
    return f"{number:,} {what}" if number == 1 else f"{number:,} {what}s"


def sentence_of(message: str) -> str:
    """First sentence of a message."""
    return re.split(r"(?<=[^.]{3})[.;] (?=[A-Z])|\? ", message, maxsplit=1)[0]
