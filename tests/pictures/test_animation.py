"""Animations, read by Pillow: frames, places, and for how long each is shown."""

from __future__ import annotations

import io
from collections.abc import Iterator

import numpy as np
from PIL import Image

from rsegen.pictures.animation import Animation
from rsegen.pictures.camera import Pixels


def square(left: int, top: int) -> Pixels:
    pixels = np.full((64, 97, 3), 200, dtype=np.uint8)  # odd, as frames are counted in twos
    pixels[top : top + 16, left : left + 16] = (180, 20, 20)
    return pixels


def read(content: bytes) -> list[tuple[int, Pixels]]:
    """Each frame as it is shown, with the milliseconds at which it ends."""
    frames = []
    with Image.open(io.BytesIO(content)) as image:
        assert image.format == "WEBP"
        for number in range(image.n_frames):  # type: ignore[attr-defined]  # of animations
            image.seek(number)
            image.load()
            frames.append((image.info["timestamp"] + image.info["duration"], np.asarray(image.convert("RGB"))))
    return frames


def is_like(one: Pixels, other: Pixels) -> bool:
    """Lossy, so a few of 255 on average."""
    return float(np.abs(one.astype(int) - other).mean()) < 4


def test_frames_are_shown_one_after_another() -> None:
    animation, frames = Animation(milliseconds=80), [square(left, 3) for left in (0, 7, 31, 81)]
    for frame in frames:
        animation.add(frame)
    shown = read(animation.file())
    assert [end for end, _ in shown] == [80, 160, 240, 320]
    assert all(is_like(one, other) for (_, one), other in zip(shown, frames, strict=True))
    assert not is_like(shown[0][1], frames[3])


def test_a_frame_that_is_like_the_one_before_it_makes_that_one_last_longer() -> None:
    animation = Animation(milliseconds=80)
    for left in (0, 0, 0, 20, 20, 0):
        animation.add(square(left, 40))
    shown = read(animation.file())
    assert [end for end, _ in shown] == [240, 400, 480]
    assert is_like(shown[2][1], square(0, 40))


def test_what_has_not_changed_is_not_encoded_again() -> None:
    """A picture of noise is large, and a square that moves over it small."""
    noise = np.random.default_rng(1).integers(0, 255, (360, 640, 3)).astype(np.uint8)
    still, moving = Animation(milliseconds=80), Animation(milliseconds=80)
    still.add(noise)
    for number in range(20):
        frame = noise.copy()
        frame[100:116, 20 * number : 20 * number + 16] = 0
        moving.add(frame)
    assert len(moving.file()) < 2 * len(still.file())
    assert len(read(moving.file())) == 20


def chunks(content: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Name and content of each chunk of a RIFF file, padded to even lengths."""
    while content:
        length = int.from_bytes(content[4:8], "little")
        yield content[:4], content[8 : 8 + length]
        content = content[8 + length + length % 2 :]


def test_the_place_and_size_of_each_frame_are_those_of_its_picture() -> None:
    """As the container says them: 24 bits each of x / 2, y / 2, width - 1 and height - 1."""
    animation = Animation(milliseconds=80)
    for left, top in ((0, 3), (7, 10), (81, 48), (80, 47)):
        animation.add(square(left, top))
    ((name, file),) = chunks(animation.file())
    assert name == b"RIFF"
    places = []
    for content in (content for name, content in chunks(file[4:]) if name == b"ANMF"):
        x, y, width, height = (int.from_bytes(content[at : at + 3], "little") for at in range(0, 12, 3))
        with Image.open(
            io.BytesIO(b"RIFF" + (len(content) - 12).to_bytes(4, "little") + b"WEBP" + content[16:])
        ) as still:
            assert still.size == (width + 1, height + 1)
        places.append((2 * x, 2 * y, 2 * x + width + 1, 2 * y + height + 1))
    assert places == [(0, 0, 97, 64), (0, 2, 23, 26), (6, 10, 97, 64), (80, 46, 97, 64)]


def test_one_frame_is_an_animation_too() -> None:
    animation = Animation(milliseconds=80)
    animation.add(square(5, 5))
    (only,) = read(animation.file())
    assert is_like(only[1], square(5, 5))
