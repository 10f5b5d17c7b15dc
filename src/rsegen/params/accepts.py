"""The type of a field that takes more than it holds, such as `chunks`, of which 3 stands for (3, 3).

    chunks: Annotated[Accepts[int | Sequence[int], Sequence[int]], Size2D(...)] = (1, 1)

Type checkers see a descriptor: the first type is what a call may set, the second what the field gives. When a program
runs, it is the first type alone, which docstrings name, as the field's sort has put its canonical form there.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    _Set_contra = TypeVar("_Set_contra", contravariant=True)
    _Held_co = TypeVar("_Held_co", covariant=True)

    class Accepts(Generic[_Set_contra, _Held_co]):
        """The descriptor that type checkers see."""

        def __get__(self, instance: object, owner: object) -> _Held_co: ...
        def __set__(self, instance: object, value: _Set_contra) -> None: ...

else:

    class Accepts:
        """The first of two types."""

        def __class_getitem__(cls, types: tuple[Any, Any]) -> Any:
            """Return it."""
            return types[0]
