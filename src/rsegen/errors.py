"""Every error that rsegen raises on purpose, each one clear line.

RsegenError
├── UserError            a request cannot be fulfilled; the command line ends with exit code 2
│   ├── ParameterError   a value is out of range, of the wrong type, or at odds with another
│   │   ├── UnknownName  a kind, key or flag that is not there; lists the known ones
│   │   └── NoSpot       a map has too few places at which a robot can start
│   ├── FileError        a file or folder cannot be read, or is not what it should be
│   ├── OutputError      the output folder is taken, or may not be written to
│   ├── PluginError      a plug-in cannot be loaded, or is not what it should be
│   ├── TooLarge         a run needs more memory or disk space than is free
│   ├── ScanError        a point cloud shows no step field, or another one than was said
│   ├── Question         a person has to say whether something is to be replaced (page/calls.py)
│   ├── NoSimulator      no simulator that is installed here can fulfil a request
│   └── NothingRuns      a running simulation should be changed, and none runs
├── WriteError           the disk failed in the middle; nothing half written is left; exit code 1
│   └── Stuck            so that not all of what was replaced could be put back; the message names it
├── Incomplete           the user's mistake showed only after something was written, which stays; exit code 1
├── WorkerLost           a worker was killed from outside; nothing half written is left; exit code 1
├── FilesDamaged         files on disk are not what rsegen wrote; exit code 1
│   └── DatasetDamaged   a data set on disk is not what was made
└── SimulatorFailed      a simulator died, fell silent or did not load its world; exit code 1
    └── NoMessage        bytes that a simulator sent are no message of their type
"""

from __future__ import annotations

import errno
import reprlib
from collections.abc import Collection, Iterable, Mapping, Sequence

REFUSED = frozenset(
    {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.EEXIST}
    | {errno.ENAMETOOLONG, errno.ELOOP}
)
"""Error numbers of a place that a user cannot write to; all others are failures of the machine."""


class RsegenError(Exception):
    """An error that rsegen raises on purpose."""


class UserError(RsegenError):
    """A request that cannot be fulfilled; the message says where, what was given and what would be right."""


class FileError(UserError):
    """A file or folder cannot be read, or is not what it should be."""


class OutputError(UserError):
    """The output folder is taken, or may not be written to."""


class PluginError(UserError):
    """A plug-in cannot be loaded, or is not what it should be; the message names the package or file."""


class TooLarge(UserError):
    """A run needs more memory or disk space than is free."""


class ScanError(UserError):
    """A point cloud shows no step field, or another one than was said."""


class NoSimulator(UserError):
    """A request that no simulator installed here can fulfil."""


class NothingRuns(UserError):
    """A request to change a running simulation, and none runs."""


class WriteError(RsegenError):
    """The disk failed in the middle of writing."""


class Stuck(WriteError):
    """The disk failed, and failed again when what was replaced was put back; the message names what was not."""


class Incomplete(RsegenError):
    """A run that cannot be finished; the message says why, and what is complete."""


class Stopped(KeyboardInterrupt):
    """A stopped run; the message says what is complete. changed: whether anything was written."""

    def __init__(self, message: str, *, changed: bool = True) -> None:
        super().__init__(message)
        self.changed = changed


class WorkerLost(RsegenError):
    """A worker was killed from outside, by the system for want of memory or by a person."""


class FilesDamaged(RsegenError):
    """Files on disk are not what rsegen wrote."""


class DatasetDamaged(FilesDamaged):
    """A data set on disk is not what was made."""


class SimulatorFailed(RsegenError):
    """A simulator died, fell silent or did not load its world."""


class NoMessage(SimulatorFailed):
    """Bytes that are no message of their type."""


class PluginWarning(UserWarning):
    """A plug-in is left out, or is another version than a recipe was made with; the work goes on."""


class ParameterError(UserError, ValueError):
    """`where: problem`, as in `obstacles[2].softness: 130 is outside 0..100`."""

    def __init__(self, where: str, problem: str) -> None:
        super().__init__(where, problem)
        self.where = where
        self.problem = problem

    def __str__(self) -> str:
        return f"{self.where}: {self.problem}" if self.where else self.problem

    def inside(self, outer: str) -> ParameterError:
        """Return the error seen from outside: `softness` inside `obstacles[2]` is `obstacles[2].softness`."""
        joint = "" if not self.where or self.where.startswith("[") else "."
        return type(self)(f"{outer}{joint}{self.where}", self.problem)

    def of(self, source: str) -> ParameterError:
        """Return the error with the file or flag that it comes from: `recipe.yaml: obstacles[2].softness`."""
        return type(self)(f"{source}: {self.where}" if self.where else source, self.problem)


class NoSpot(ParameterError):
    """A map has too few places at which a robot can start; the message describes the best one."""


class inside:  # noqa: N801  # read as the word that it is: with inside("obstacles[0]")
    """A context that prefixes the place of ParameterErrors that are raised inside with an outer one."""

    __slots__ = ("_outer",)

    def __init__(self, outer: str) -> None:
        self._outer = outer

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, ParameterError):
            raise error.inside(self._outer) from None


class UnknownName(ParameterError):
    """A name that is not among the known ones; the message gives the nearest and lists them all."""

    @classmethod
    def among(
        cls, where: str, what: str, name: object, known: Iterable[str], meant: Iterable[str] = (), instead: str = ""
    ) -> UnknownName:
        """Return the error for `name`, which should have been one of `known`.

        meant: those that are also called so; instead: what people who want this do, in words
        """
        names = sorted(known)
        hint = f"; {instead}" if instead else did_you_mean(name, names, meant)
        listed = f"known: {', '.join(names)}" if names else "there is none"
        return cls(where, f"unknown {what} {shown(name)}{hint} ({listed})")


def did_you_mean(name: object, known: Iterable[str], meant: Iterable[str] = ()) -> str:
    """Return `; did you mean 'wood'?` for another word or a misspelt name; an empty text if no known one is near."""
    import difflib

    if not isinstance(name, str):
        return ""
    names = list(known)
    near = [*meant] or _meant(name, names) or difflib.get_close_matches(name[:100], names, n=1)
    return f"; did you mean {' or '.join(map(repr, near))}?" if near else ""


def _meant(name: str, known: Collection[str]) -> list[str]:
    """Return the known parameter, or flag, that another word for it means, if any."""
    words = _PARAMETERS.get(name.strip("-").replace("-", "_").lower(), ())
    flags = [f"--{word.replace('_', '-')}" for word in words] if name.startswith("-") else words
    return [word for word in flags if word in known][:1]


_PARAMETERS: Mapping[str, tuple[str, ...]] = {
    word: tuple(names.split())
    for words, names in {
        "height heights max_height number_of_levels steps": "levels unit_cm",
        "levels softness first last": "obstacle obstacles",
        "start begin from position center centre": "first",
        "end stop goal": "last",
        "smoothness smooth hardness": "softness",
        "probability probabilities": "weights",
        "sigma std deviation": "spread",
        "size": "chunk_size",
        "width length": "chunks duration",
        "unit resolution height_step step": "unit_cm",
        "cell_size block_size": "block_width_cm",
        "frame frames border edge": "boundary",
        "count number n n_maps num_maps number_of_maps": "maps",
        "out dir directory folder": "output",
        "overwrite replace": "force",
        "threads jobs cores parallel processes": "workers",
        "format type": "to formats",
        "model": "robot",
        "time": "duration",
        "random_seed": "seed",
    }.items()
    for word in words.split()
}
"""Words of other programs for parameters and flags that are called otherwise here; of several names the first that is
known where the word was given is meant. Commands, and things in registries, say themselves what they are `also`."""


def refuse_unknown(what: str, names: Iterable[str], known: Collection[str]) -> None:
    """Raise an UnknownName for the first name that is not known."""
    for name in names:
        if name not in known:
            raise UnknownName.among("", what, name, known)


_HOW_MADE = {
    "MapDesign": "recipe, which rsegen.load reads and rsegen.recipe_of makes of a field",
    "Recipe": "recipe, which rsegen.load reads and rsegen.recipe_of makes of a field",
    "Scene": "scene, which rsegen.compose makes of a recipe",
    "StepField": "field, which rsegen.build makes of a recipe",
}
"""Name of the values of each class that functions in Python take, and the calls that make them."""


def refuse_other(where: str, value: object, *kinds: type) -> None:
    """Raise a ParameterError for a value that is of none of these classes, and say how one is made, or where it is."""
    if not isinstance(value, kinds):
        named = (_HOW_MADE.get(kind.__name__, f"{kind.__name__} of {kind.__module__}") for kind in kinds)
        wanted = ", or ".join(f"{'an' if text[0] in 'AEIO' else 'a'} {text}" for text in named)
        raise ParameterError(where, f"{shown(value)} is not {wanted}")


def library_message(error: BaseException) -> str:
    """Return the message of a library's error on one short line; a KeyError has the missing name alone."""
    missing = "lacks " if isinstance(error, KeyError) else ""
    return missing + " ".join(str(error).split())[:_LONGEST] or type(error).__name__


def system_message(error: OSError, about: str = "") -> str:
    """Return why the system refused something, behind the file that it was about, or `about` if it names none."""
    where = error.filename or about
    return f"{where}: {system_reason(error)}" if where else system_reason(error)


def system_reason(error: OSError) -> str:
    """Return why the system refused something, in words."""
    return error.strerror or str(error) or type(error).__name__


def shown(value: object) -> str:
    """`value` as an error message shows it: short, and on one line whatever it is."""
    if value is None:
        return "an empty value"  # what stands after `boundary:` in a file is Python's None, and not the word none
    text = " ".join(_SHORT.repr(value).splitlines())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def some_of(names: Sequence[str], most: int = 12) -> str:
    """Return names with commas between them, the first ones of many: an arm has more than a dozen joints."""
    return ", ".join(names[:most]) + (", ..." if len(names) > most else "")


def printable(text: str) -> str:
    """`text` with escapes for what a terminal would obey or cannot show: control and bidi characters, surrogates."""
    if text.translate(_LAYOUT).isprintable():
        return text
    return "".join(
        character if character.isprintable() or character in "\n\t" else repr(character)[1:-1] for character in text
    )


def line_of(message: str) -> str:
    """Return a message as one printable, readable line: long paths, and what is too long, without their middle."""
    words = " ".join(_without_middle(printable(word), _LONGEST_WORD) for word in message.split())
    return _without_middle(words, _LONGEST_LINE)


def _without_middle(text: str, most: int) -> str:
    return text if len(text) <= most else f"{text[: most // 2]}...{text[-most // 2 + 3 :]}"


_LAYOUT = {ord("\n"): None, ord("\t"): None}
"""Characters that shape a text, and are no danger to a terminal."""

_LONGEST_LINE = 900
"""Letters of a message: a terminal of 80 columns shows it in twelve lines, with two long paths in it."""

_LONGEST_WORD = 300
"""Letters of a word: a path longer than this is recognised by its start and its end."""

_LONGEST = 120
"""Letters of a value, or of a library's message, in a message of rsegen: one line of a wide terminal."""


class _Repr(reprlib.Repr):
    """The short representations of reprlib, except for numbers too long for Python to write out."""

    def repr_int(self, x: int, level: int) -> str:
        """Return the digits of a number, or a few words."""
        try:
            str(x)
        except ValueError:
            return "a number of thousands of digits"
        return super().repr_int(x, level)


# Values come from files of anybody: three levels of lists, and numbers and texts by their ends.
_SHORT = _Repr()
_SHORT.maxlevel = 3
_SHORT.maxstring = _SHORT.maxother = 60
_SHORT.maxlong = 40
