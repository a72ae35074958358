"""Pictures one after another as a file: GIF, and MP4 where an encoder is installed."""

from __future__ import annotations

import io
import shutil
import subprocess
from collections.abc import Sequence
from typing import Any

import numpy as np

from fab.errors import InvalidJob
from fab.scratch import temporary_folder

__all__ = ["FRAME_MS", "encoder", "gif_bytes", "mp4_bytes", "there_and_back"]

# How long a picture is shown, and the first and last of a motion.
FRAME_MS, _REST_MS = 100, 1500
_COLOURS = 255
_NEARLY_WHITE = 244
# Pictures from which the colours of all are taken.
_SAMPLED = 6
_LEAST_SECONDS = 120


def there_and_back(count: int) -> tuple[list[int], list[int]]:
    """Numbers of pictures to the last one and back, and how long each is shown, ms.

    >>> there_and_back(3)
    ([0, 1, 2, 1], [1500, 100, 1500, 100])
    """
    order = [*range(count), *range(count - 2, 0, -1)]
    times = [FRAME_MS] * len(order)
    times[0] = times[count - 1] = _REST_MS
    return order, times


def gif_bytes(pictures: Sequence[Any], order: Sequence[int], times_ms: Sequence[int]) -> bytes:
    """An endless GIF of Pillow images of one size, in the colours that are found in some of them.

    order : which is shown, one after another; times_ms : for how long.
    """
    from PIL import Image

    chosen = np.unique(np.linspace(0, len(pictures) - 1, _SAMPLED).round().astype(int)).tolist()
    pixels = np.concatenate([np.asarray(pictures[k].reduce(2)).reshape(-1, 3) for k in chosen])
    own, counts = np.unique(pixels, axis=0, return_counts=True)
    # colours of small things count too, such as those of a scale
    weighed = np.repeat(own, np.ceil(np.sqrt(counts)).astype(int), axis=0)
    chosen_colours = Image.fromarray(weighed[None]).quantize(_COLOURS, Image.Quantize.MEDIANCUT)
    colours = np.array((chosen_colours.getpalette() or [])[: 3 * _COLOURS]).reshape(-1, 3)
    # white itself, and nothing beside it: Pillow looks colours up by their upper six bits
    colours[colours.min(axis=1) >= _NEARLY_WHITE] = 255
    palette = Image.new("P", (1, 1))
    palette.putpalette([255, 255, 255, *colours.ravel().tolist()])
    small = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    frames = [small[k] for k in order]
    out = io.BytesIO()
    frames[0].save(
        out,
        format="GIF",
        save_all=True,
        append_images=frames[1:],
        duration=list(times_ms),
        loop=0,
        optimize=False,
    )
    return out.getvalue()


def encoder() -> str | None:
    """The program that makes MP4 files: that of imageio-ffmpeg, or ffmpeg; None where neither is.

    `pip install 'quadfold[mp4]'` brings the first of them.
    """
    try:
        import imageio_ffmpeg
    except ImportError:
        return shutil.which("ffmpeg")
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:  # it is installed without its program
        return shutil.which("ffmpeg")


def mp4_bytes(pictures: Sequence[Any], order: Sequence[int], times_ms: Sequence[int]) -> bytes:
    """An MP4 (H.264) of Pillow images of one size, as `gif_bytes`, shown once.

    Raises `InvalidJob` where there is no encoder, or where it fails.
    """
    program = encoder()
    if program is None:
        raise InvalidJob(
            "mp4: no encoder is installed. `pip install 'quadfold[mp4]'` brings one, and so does "
            "ffmpeg; a GIF needs none."
        )
    width, height = (side // 2 * 2 for side in pictures[0].size)  # H.264 wants even sides
    raw = [picture.crop((0, 0, width, height)).tobytes() for picture in pictures]
    repeats = [max(1, round(time / FRAME_MS)) for time in times_ms]
    with temporary_folder() as folder:
        target = folder / "movie.mp4"
        command = [
            *(program, "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"),
            *("-s", f"{width}x{height}", "-r", f"{1000 / FRAME_MS:g}", "-i", "-"),
            *("-an", "-c:v", "libx264", "-pix_fmt", "yuv420p", "-threads", "1"),
            *("-fflags", "+bitexact", "-flags:v", "+bitexact", "-movflags", "+faststart"),
            str(target),
        ]
        data = b"".join(raw[k] * n for k, n in zip(order, repeats, strict=True))
        seconds = _LEAST_SECONDS + len(data) // 10_000_000
        try:
            done = subprocess.run(command, input=data, capture_output=True, timeout=seconds)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise InvalidJob(
                f"mp4: {program} did not run: {error}. A GIF needs no encoder."
            ) from error
        if done.returncode or not target.is_file():
            why = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or ["no file"]
            raise InvalidJob(f"mp4: {program} failed: {why[0]}. A GIF needs no encoder.")
        return target.read_bytes()
