"""Expand Xacro, the macro language of ROS's robots, by ROS's package xacro, in another process.

Xacro evaluates Python, and its own restrictions do not keep a file from running code. Here an expression may be
arithmetic, comparisons, subscripts, and calls of the functions in _CALLED and _METHODS. A package in $(find ...) is
found as the package of a mesh is, without ROS. A file of a package that is not found is not included: makers' robots
include the macros of sensors that most of them do not carry. Elements are counted, as macros may call themselves, and
the process and each expression have little time and memory. What breaks it: lambdas and comprehensions;
`xacro FILE > r.urdf` expands them.
"""

from __future__ import annotations

import ast
import json
import math
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from rsegen.errors import FileError, UserError, library_message, line_of
from rsegen.input_files import text_of, xml_root
from rsegen.params.extras import pip_install
from rsegen.robots import XACRO
from rsegen.robots.files.uris import found_package, installed

_SECONDS = 20
"""CPU time of the other process; the macros of a robot with an arm and a gripper take about one second."""

_WAIT = 3
"""Times that, in which a busy machine, or one without limits of CPU time, has to be done."""

_MEMORY = 2 * 2**30
"""Bytes of address space of the other process, of which Python with numpy takes about a half."""

_LARGEST = 4 * 2**20
"""Characters of an expanded file, as many as of one that is none."""

_ELEMENTS = 20_000
"""Elements that are expanded, of which a call of a macro counts as two: a robot with two arms has some thousand.

A macro that calls itself twice would go on until time or memory is over."""

_EXPRESSION = 1.0
"""Seconds of CPU time of one expression, which takes less than a thousandth of that."""

_NAMESPACES = ("math", "python", "xacro")
"""Names before the dot of a function."""

_CALLED = {
    *("abs", "bool", "dict", "float", "int", "len", "list", "max", "min", "range", "round", "sorted", "str", "sum"),
    "tuple",
    *(name for name, function in vars(math).items() if callable(function) and not name.startswith("_")),
    *("abs_filename", "arg", "dotify", "fatal", "load_yaml", "message", "warning"),
}
"""Functions that an expression may call: none of them gives a way to Python's own."""

_METHODS = {
    *("count", "endswith", "find", "index", "isdigit", "join", "lower", "lstrip", "replace", "rfind", "rstrip"),
    *("split", "startswith", "strip", "title", "upper"),
    *("get", "items", "keys", "pop", "values"),
}
"""Methods that an expression may call: those of texts, of tables that are read from YAML, and of lists of which a macro
that calls itself takes an item each time."""

_ALLOWED = (
    *(ast.Expression, ast.Constant, ast.Name, ast.Load, ast.BinOp, ast.UnaryOp, ast.BoolOp, ast.Compare, ast.IfExp),
    *(ast.operator, ast.unaryop, ast.boolop, ast.cmpop, ast.Subscript, ast.Slice, ast.List, ast.Tuple, ast.Dict),
    *(ast.Call, ast.keyword, ast.Attribute),
)


def is_xacro(root: Element, where: str) -> bool:
    """Return whether a file has to be expanded: by its name, or as it has macros, or is URDF with expressions."""
    if where.endswith(".xacro"):
        return True
    if any(element.tag.startswith("{") and "xacro" in element.tag.partition("}")[0] for element in root.iter()):
        return True
    texts = (text for element in root.iter() for text in (element.text or "", *element.attrib.values()))
    return root.tag == "robot" and any("${" in text or "$(" in text for text in texts)


_OF_URDF = {
    *("link", "joint", "gazebo", "material", "transmission", "ros2_control", "sensor", "light", "projector", "contact"),
    *("inertial", "visual", "collision", "origin"),
}
"""Elements of a <robot> and a <link>, which may have the names of macros."""


def bare_macros(text: str) -> tuple[str, ...]:
    """Return the properties and macros of a text that stand there without xacro:, as before ROS Jade."""
    root = xml_root(text, "")
    macros = {element.get("name") for element in root.iter() if element.tag.endswith("}macro")} - _OF_URDF
    ours = {element.tag for element in root if element.tag in ("property", "macro")}
    ours |= {inner.tag for element in (root, *root.iter("link")) for inner in element if inner.tag in macros}
    return tuple(sorted(ours, reverse=True))


def _without_prefix(bare: Iterable[str]) -> str:
    names = ", ".join(f"<{name}>" for name in bare)
    return f"there is no xacro: before the names of {names}, without which ROS expands nothing"


def with_arguments(file: str) -> tuple[str, dict[str, str]]:
    """Return the path and the arguments in FILE NAME:=VALUE ..., as ROS's xacro takes them on a command line."""
    match = re.search(r"(?:\s+[A-Za-z_]\w*:=\S*)+\s*$", file, re.ASCII)
    if match is None:
        return file, {}
    return file[: match.start()], dict(word.split(":=", 1) for word in match[0].split())


def expanded(text: str, where: str, arguments: Mapping[str, str]) -> tuple[str, Sequence[str]]:
    """Return the XML of a text of Xacro, and the packages of which it includes files that are not found nor needed.

    An argument that is not given has its default.
    """
    if bare := bare_macros(text):
        raise FileError(f"{where}: {_without_prefix(bare)}")
    if XACRO.is_missing:
        raise UserError(f"{where}: needs xacro, which is not installed; {pip_install([XACRO.name])}")
    # The process prints the result or the reason; one that broke a limit was ended by the signal of that limit.
    environment = {**os.environ, "PYTHONSAFEPATH": "1", "PYTHONIOENCODING": "utf-8"}  # imports nothing from this folder
    try:
        ended = subprocess.run(  # noqa: S603  # no shell, and only our own words
            [sys.executable, "-m", "rsegen.robots.files.xacro_files", where],
            input=json.dumps({"text": text, "arguments": dict(arguments), "seconds": _SECONDS}),
            encoding="utf-8",
            capture_output=True,
            env=environment,
            timeout=_WAIT * _SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise FileError(f"{where}: its macros are not expanded after {_WAIT * _SECONDS} s") from None
    except (OSError, ValueError) as error:  # a name with a null character, or an output that is no text
        raise FileError(f"{where}: {library_message(error)}") from None
    if ended.returncode == -getattr(signal, "SIGPROF", 0):
        raise FileError(f"{where}: xacro cannot expand it: an expression takes more than {_EXPRESSION:g} s")
    if ended.returncode == -getattr(signal, "SIGXCPU", 0):
        raise FileError(f"{where}: its macros are not expanded after {_SECONDS} s")
    if ended.returncode:
        raise FileError(f"{where}: xacro cannot expand it: {_why(ended)}")
    result = json.loads(ended.stdout)
    return result["text"], result["missing"]


def _why(ended: subprocess.CompletedProcess[str]) -> str:
    """Return why a process has expanded nothing: the reason that it printed, or how it ended without one."""
    if reason := line_of(ended.stdout):
        return reason
    *_, last = ["", *ended.stderr.splitlines()]
    is_memory = ended.returncode < 0 or "MemoryError" in last
    return "it needs too much memory" if is_memory or not last else line_of(last)


def main(where: str) -> int:
    """Print the expanded text of the Xacro on stdin, or with exit code 1 the reason why it cannot be expanded."""
    result, sys.stdout = sys.stdout, sys.stderr  # messages of the macros go there
    task, missing, included = json.load(sys.stdin), dict[str, None](), list[Path]()
    with suppress(ImportError):  # there is none in Windows
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        resource.setrlimit(resource.RLIMIT_CPU, (task["seconds"], task["seconds"] + 1))
    try:
        text = _expanded(task["text"], where, task["arguments"], missing, included)
    except FileError as error:
        result.write(str(error))
        return 1
    except Exception as error:  # macros fail in as many ways as programs
        result.write(_reason(error, missing, included))
        return 1
    json.dump({"text": text, "missing": list(missing)}, result)
    return 0


def _reason(error: Exception, missing: Mapping[str, None], included: Iterable[Path]) -> str:
    """Return why a file cannot be expanded, with what may be done about it."""
    inner = getattr(error, "exc", None)
    # Xacro says the class and the message of what $(...) raises, and the message once more.
    reason = library_message(inner if inner and str(error).startswith("<class") else error)
    if isinstance(inner, FileNotFoundError):
        return f"it includes {inner.filename}, and there is no such file"
    undefined = re.search(r"Undefined substitution argument (\w+)", reason)
    if undefined:
        return f"{reason}; pass it after the file, as in 'FILE {undefined[1]}:=VALUE'"
    is_elsewhere = "nknown macro" in reason or "is not defined" in reason
    for file in included if is_elsewhere else ():
        if bare := bare_macros(text_of(file, _LARGEST >> 20, "a file of Xacro")):
            return f"{reason}; {file}: {_without_prefix(bare)}"
    if is_elsewhere and missing:
        advice = "put them next to that of the file, or their folder into ROS_PACKAGE_PATH"
        return f"{reason}; these packages are not found: {', '.join(missing)}; {advice}"
    if is_elsewhere:  # as in a part of a robot, whose macros are in other parts
        return f"{reason}; if it is a part of a robot, use the file of the robot that includes it"
    return reason


class _Missing(ValueError):
    """A package in $(find ...) is not found."""

    def __init__(self, name: str) -> None:
        super().__init__(f"the package {name} is not found")
        self.package = name


def _expanded(
    text: str, where: str, arguments: Mapping[str, str], missing: dict[str, None], included: list[Path]
) -> str:
    """Return the expanded text; `missing` gets the packages that are not found, `included` the files that are."""
    import xacro
    from xacro import substitution_args

    include_files = xacro.get_include_files

    def found_files(filename: str, symbols: Any) -> Iterator[str]:
        """Yield the files that an element includes; none if their package is not found."""
        try:
            for name in include_files(filename, symbols):
                included.append(installed(Path(name)))
                yield str(included[-1])
        except Exception as error:
            inner: Any = error
            while inner is not None and not isinstance(inner, _Missing):  # xacro wraps ours in one or two of its own
                inner = getattr(inner, "exc", None) or inner.__cause__ or inner.__context__
            if inner is None:
                raise
            missing[inner.package] = None

    # Xacro has no interface for these, so its own functions are replaced, in a process that does nothing else.
    xacro.get_include_files = found_files
    macros = set[str]()
    xacro.eval_all = _counted(xacro.eval_all, macros)
    xacro.safe_eval = _evaluated
    substitution_args._eval_find = partial(_package, where)
    substitution_args._eval = _calculated
    xacro.init_stacks(where)
    document = xacro.parse(text)
    xacro.process_doc(document, mappings=dict(arguments))
    root = document.documentElement
    tags = {getattr(e, "tagName", "") for of in (root, *root.getElementsByTagName("link")) for e in of.childNodes}
    if bare := tags & (macros - _OF_URDF):  # of files that are included
        raise FileError(_without_prefix(sorted(bare)))
    result: str = root.toxml()
    if len(result) > _LARGEST:
        raise ValueError(f"its macros make {len(result) / 2**20:.0f} MiB of it")
    return result


def _counted(expand: Callable[..., Any], names: set[str]) -> Callable[..., Any]:
    """Return a function that expands an element, and raises a ValueError after too many elements.

    names: gets the names of all macros of the file
    """
    calls = count(1)

    def counted(node: Any, macros: Any, symbols: Any) -> Any:
        if (call := next(calls)) > _ELEMENTS:
            raise ValueError(f"its macros make more than {_ELEMENTS:,} elements")
        expand(node, macros, symbols)
        if call == 1:  # the whole document, so all macros are known at its end
            names.update(macros)

    return counted


def _evaluated(expression: str, names: dict[str, Any], inner: dict[str, Any] | None = None) -> Any:
    """Return the value of an expression; ValueError if it has anything that may do more than calculate."""
    # A namespace such as math may only stand before a dot, so these places are collected first.
    tree = ast.parse(expression.strip(), mode="eval")
    roots = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    for node in ast.walk(tree):
        if not _is_harmless(node, is_before_dot=id(node) in roots):
            raise ValueError(
                f"{ast.unparse(node)} is more than arithmetic, and is not evaluated; expand it by ROS's xacro"
            )
    names.update(__builtins__={})
    with _timed():
        value = eval(compile(tree, "<expression>", "eval"), names, inner)  # noqa: S307  # only what was looked at
    if isinstance(value, str | list | tuple) and len(value) > _LARGEST:
        raise ValueError(f"an expression makes a value of {len(value):,} parts")
    return value


@contextmanager
def _timed() -> Iterator[None]:
    """End this process if what is done inside takes long, even within one call of Python's own code, as of a power."""
    if not hasattr(signal, "setitimer"):  # Windows
        yield
        return
    signal.setitimer(signal.ITIMER_PROF, _EXPRESSION)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def _is_harmless(node: ast.AST, *, is_before_dot: bool) -> bool:
    if isinstance(node, ast.Call):
        function = node.func
        if isinstance(function, ast.Name):
            named = all(word.arg for word in node.keywords) if function.id == "dict" else not node.keywords
            if function.id == "map":  # of a function that may be called anyway
                function = node.args[0] if node.args else function
            return isinstance(function, ast.Name) and function.id in _CALLED and named
        callable_names = _CALLED if _is_of_namespace(function) else _METHODS
        return isinstance(function, ast.Attribute) and not node.keywords and function.attr in callable_names
    if isinstance(node, ast.Attribute):
        if _is_of_namespace(node):  # numbers, and what is called; other attributes are entries of tables
            return node.attr in {*_CALLED, "pi", "e", "tau", "inf"}
        return not node.attr.startswith("_")
    if isinstance(node, ast.Name):  # a namespace alone could get another name
        return not node.id.startswith("__") and (is_before_dot or node.id not in _NAMESPACES)
    return isinstance(node, _ALLOWED)


def _is_of_namespace(node: ast.AST) -> bool:
    return isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in _NAMESPACES


def _calculated(expression: str, context: Mapping[str, Any]) -> str:
    """Return the value of $(eval ...), in which arguments stand by their names; it ends at the first parenthesis."""
    from xacro import substitution_args

    values = {name: substitution_args.convert_value(text, "auto") for name, text in context.get("arg", {}).items()}
    return str(_evaluated(expression, {**values, **substitution_args._eval_dict}))


def _package(where: str, name: str) -> str:
    folder = found_package(name, Path(where))
    if folder is None:
        raise _Missing(name)
    return str(folder)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
