"""What is typed and pasted at random: right, wrong and hostile texts, none of them a path out of the folder."""

from __future__ import annotations

from random import Random

TEXTS = (
    *(
        "",
        " ",
        "0",
        "1",
        "2",
        "3",
        "4",
        "5",
        "7",
        "10",
        "12",
        "20",
        "40",
        "100",
        "-1",
        "-3",
        "+2",
        "007",
        "1_0",
        "0x10",
    ),
    *("0.1", "0.5", "2.5", "5.5", "99.99999", "1e3", "1e400", "-1e400", "nan", "inf", "-inf", "5,5", "1.", ".5", "1;2"),
    *(
        "32766",
        "32767",
        "32768",
        "2147483647",
        "2147483648",
        "4294967296",
        "9" * 19,
        "9" * 30,
        "9" * 300,
        "-" + "9" * 30,
    ),
    *("abc", "a,b", "peek", "peak", "matrix", "random", "pallet", "horizontal_barrier", "Peak", "none", "None", "yes"),
    *(
        "7",
        "2,3",
        "2, 3",
        "[2, 3]",
        "[random, 3]",
        "random,random",
        "random, 4",
        "0,0",
        "9,9",
        "9, 0",
        "99,99",
        "1,2,3",
    ),
    *(",", ",,", "()", "[]", "{}", "'", '"', "\\", "&", "&a", "%s", "{0}", "#ff0000", "#ff0000,#00ff00", "#12", "#"),
    *("0.9,0.1", "0.9,rough", "10,10,20", "1,0,2", "5,5,5,5,5", "2x2", "3x1", "2x", "x", "0 1 2", ". 1 .", "0 1\n2 3"),
    *("0 1\n2", "\n", "\t", "a\tb", "\u0000", "\u202e", "\u00e4\u00f6\u00fc", "\u4e2d\u6587", "\U0001f9f1", "e\u0301"),
    *("\u0663", "\uff15", "<b>7</b>", "<img src=x>", "a b", " 5 ", "5 units", "x" * 70, "x" * 600, "rse", "-x", "~"),
)
"""Also digits of other alphabets, control characters, HTML and format strings."""

FOLDERS = ("worlds", "out", "sub", "taken.txt", "", "a b", "recipe.yaml", "<b>", "\u4e2d", "x" * 300, "~", "data")
"""For the fields of output folders; taken.txt is a file, data a data set."""

FILES = (
    *("recipe.yaml", "large.yaml", "huge.yaml", "wrong.yaml", "broken.yaml", "empty.json", "nowhere.yaml", "data"),
    *("heights.csv", "grey.png", "broken.png", "letters.csv", "taken.txt", "new.yaml", "new.json", "new.png", "new.x"),
    *("sub", "nowhere.csv", "data#1", "recipe"),
)
"""Names in dialogs that ask for a file."""


def numbers(seed: int) -> Random:
    """The random numbers of a seed."""
    return Random(seed)  # noqa: S311  # they choose what is typed
