"""Movies: GIF files of Pillow images, and MP4 files where there is an encoder."""

import io
import subprocess

import numpy as np
import pytest
from PIL import Image

from fab.errors import InvalidJob
from fab.viewing import movie_files
from fab.viewing.movie_files import encoder, gif_bytes, mp4_bytes, there_and_back


def squares(count=4, size=(120, 80)):
    """White images with a square that moves to the right and turns from red to blue."""
    out = []
    for number in range(count):
        image = np.full((size[1], size[0], 3), 255, np.uint8)
        share = number / max(1, count - 1)
        left = round(share * (size[0] - 30))
        image[20:50, left : left + 30] = [round(220 * (1 - share)), 30, round(220 * share)]
        out.append(Image.fromarray(image))
    return out


def test_gifs_have_all_frames_in_their_order_with_their_times():
    order, times = there_and_back(4)
    data = gif_bytes(squares(), order, times)
    assert data == gif_bytes(squares(), order, times)
    with Image.open(io.BytesIO(data)) as movie:
        assert movie.n_frames == len(order) == 6
        for number, (place, time) in enumerate(zip(order, times, strict=True)):
            movie.seek(number)
            frame = np.asarray(movie.convert("RGB"), int)
            assert movie.info["duration"] == time
            left = round(place / 3 * 90)
            assert (frame[0, 0] == 255).all()
            assert (frame[:, :left] == 255).all()
            assert (
                np.abs(frame[35, left + 15] - squares()[place].getpixel((left + 15, 35))).max() < 40
            )


def test_colours_of_small_things_are_kept():
    """A scale of colours below a large face of one colour."""
    image = np.full((400, 400, 3), 255, np.uint8)
    image[20:300, 20:380] = [200, 30, 30]
    scale = np.linspace(0, 1, 200)[:, None] * [-200, 100, 40] + [220, 60, 80]
    image[360:374, 100:300] = np.repeat(scale[None], 14, axis=0)
    with Image.open(io.BytesIO(gif_bytes([Image.fromarray(image)] * 3, [0, 1], [1, 1]))) as movie:
        shown = np.asarray(movie.convert("RGB"), int)
    assert np.abs(shown[365, 100:300] - image[365, 100:300]).max() < 12


def test_there_and_back_of_few_pictures():
    assert there_and_back(1) == ([0], [1500])
    assert there_and_back(2) == ([0, 1], [1500, 1500])


def test_a_single_picture_is_a_gif():
    with Image.open(io.BytesIO(gif_bytes(squares(1), *there_and_back(1)))) as movie:
        assert movie.n_frames == 1


@pytest.mark.skipif(encoder() is None, reason="no encoder: pip install 'quadfold[mp4]'")
@pytest.mark.parametrize("size", [(120, 80), (121, 81)])
def test_mp4_files_have_every_picture_as_long_as_it_is_shown(size, tmp_path):
    order, times = [0, 1, 2, 3], [100, 300, 100, 500]
    data = mp4_bytes(squares(size=size), order, times)
    assert data == mp4_bytes(squares(size=size), order, times)
    path = tmp_path / "movie.mp4"
    path.write_bytes(data)
    command = [
        encoder(),
        "-loglevel",
        "error",
        "-i",
        path,
        "-f",
        "rawvideo",
        "-pix_fmt",
        "rgb24",
        "-",
    ]
    raw = subprocess.run(command, capture_output=True, check=True, timeout=60).stdout
    frames = np.frombuffer(raw, np.uint8).reshape(-1, 80, 120, 3)
    assert len(frames) == 10
    shown = [k for k, time in zip(order, times, strict=True) for _ in range(time // 100)]
    for frame, place in zip(frames, shown, strict=True):
        expected = np.asarray(squares(size=size)[place], int)[:80, :120]
        assert np.abs(frame - expected).mean() < 8


def test_a_missing_encoder_and_one_that_fails_are_told(monkeypatch):
    monkeypatch.setattr(movie_files, "encoder", lambda: None)
    with pytest.raises(InvalidJob, match="no encoder is installed"):
        mp4_bytes(squares(), [0], [100])
    monkeypatch.setattr(movie_files, "encoder", lambda: "false")
    with pytest.raises(InvalidJob, match="false failed"):
        mp4_bytes(squares(), [0], [100])
    monkeypatch.setattr(movie_files, "encoder", lambda: "/nowhere/ffmpeg")
    with pytest.raises(InvalidJob, match="did not run"):
        mp4_bytes(squares(), [0], [100])
