"""Broken surroundings of a command: disks, folders, links, clocks, homes, locales, streams, sizes.

Each fault changes a world or how a command is started in it. Some leave what is made as it is;
others may end it with a sentence, and nothing half-written.
"""

from __future__ import annotations

import os
import random
import resource
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from fuzz.fault_worlds import (
    OLD,
    Run,
    Whole,
    World,
    faults_of,
    prepared,
    run_to_end,
    tree,
)

__all__ = ["FAULTS", "Fault", "broken"]

# What a command may end with that met a fault: made, made with an error, or refused.
_ANY = (0, 1, 2)


@dataclass
class Surroundings:
    """How a command is started: its environment, streams, and what its process does first."""

    world: World
    whole: Whole
    numbers: random.Random
    environment: dict[str, str]
    stack: ExitStack
    streams: dict[str, Any] = field(default_factory=dict)
    first: list[Callable[[], None]] = field(default_factory=list)
    prefix: list[str] = field(default_factory=list)
    more: list[str] = field(default_factory=list)
    during: list[Callable[[Run], None]] = field(default_factory=list)

    @property
    def out(self) -> Path:
        return self.world.path / self.whole.command.out

    def begin(self) -> None:
        for act in self.first:
            act()


@dataclass(frozen=True)
class Fault:
    """A name, the command, what is broken; whether the command makes what it makes otherwise.

    other : a command that runs at the same time. makes_others : whether what it makes is another
    thing than without.
    """

    name: str
    command: str
    broken: Callable[[Surroundings], None]
    is_harmless: bool = False
    other: str = ""
    makes_others: bool = False


def broken(
    fault: Fault, wholes: Mapping[str, Whole], world: World, numbers: random.Random
) -> list[str]:
    """What is wrong after a command was run with a fault."""
    whole = wholes[fault.command]
    prepared(whole.command, world)
    with ExitStack() as stack:
        found = Surroundings(world, whole, numbers, world.environment(), stack)
        fault.broken(found)
        whole, before = found.whole, tree(world.path)
        command = replace(whole.command, words=(*whole.command.words, *found.more))
        how = {
            "environment": found.environment,
            "before": found.begin,
            "prefix": found.prefix,
            **found.streams,
        }
        beside = None
        if fault.other:
            beside = Run(world, wholes[fault.other].command)
        if found.during:
            run = Run(world, command, **how)
            for act in found.during:
                act(run)
            ended = run.ended()
        else:
            ended = run_to_end(world, command, **how)
        codes: Sequence[int] = (whole.code,) if fault.is_harmless else _ANY
        if beside is not None:
            other = beside.ended()
            also = wholes[fault.other]
            whole = replace(whole, files={**also.files, **whole.files})
            assert other.code in (also.code, 2), other
            if fault.command == "sweep":
                codes = (0, 2)  # one of two sweeps is refused
        return faults_of(
            world,
            whole,
            before,
            ended,
            codes=codes,
            is_complete=fault.is_harmless and 2 not in codes,
            any_files=fault.makes_others,
        )


@contextmanager
def mounted(place: Path, *options: str) -> Iterator[None]:
    """Something mounted at a place. Wants root."""
    subprocess.run(["mount", *options, str(place)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", "-l", str(place)], check=False)


def small_disk(folder: str, kilobytes: int) -> Callable[[Surroundings], None]:
    """A disk that has so much room, with files of an earlier run where it has."""

    def act(on: Surroundings) -> None:
        place = on.world.path / folder
        size = f"size={kilobytes}k"
        on.stack.enter_context(mounted(place, "-t", "tmpfs", "-o", size, "tmpfs"))

    return act


def read_only(folder: str) -> Callable[[Surroundings], None]:
    """A folder on a disk that takes no files, not even those of root."""

    def act(on: Surroundings) -> None:
        place = on.world.path / folder
        on.stack.enter_context(mounted(place, "--bind", str(place)))
        subprocess.run(["mount", "-o", "remount,bind,ro", str(place)], check=True)

    return act


def another_user(on: Surroundings) -> None:
    """A user who may read everything and not write here, root without its power over files."""
    on.out.chmod(0o555)
    on.prefix = ["setpriv", "--bounding-set=-dac_override,-dac_read_search,-fowner"]


def vanishing(folder: str, *, is_made_again: bool) -> Callable[[Surroundings], None]:
    """A folder that somebody removes again and again while the command runs."""

    def act(on: Surroundings) -> None:
        place, over = on.world.path / folder, threading.Event()

        def vanish() -> None:
            while not over.wait(0.01):
                shutil.rmtree(place, ignore_errors=True)
                if is_made_again:
                    place.mkdir(parents=True, exist_ok=True)

        def until_it_ends(run: Run) -> None:
            thread = threading.Thread(target=vanish)
            thread.start()
            run.process.wait()
            over.set()
            thread.join()
            place.mkdir(parents=True, exist_ok=True)

        on.during.append(until_it_ends)

    return act


def linked(target: str) -> Callable[[Surroundings], None]:
    """Links in the place of every file: to nothing, to itself, or to a file that must stay."""

    def act(on: Surroundings) -> None:
        kept = on.world.path / "kept.txt"
        kept.write_bytes(OLD)
        for name in on.whole.files:
            place = on.out / name
            aim = {"nothing": on.world.path / "nowhere" / name, "itself": place, "file": kept}
            place.symlink_to(aim[target])

    return act


def linked_folder(on: Surroundings) -> None:
    """The folder to write into is a link to one elsewhere in the working folder."""
    on.out.rmdir()
    (on.out.parent / "other").mkdir()
    on.out.symlink_to("other")
    on.whole = replace(on.whole, command=replace(on.whole.command, out="here/other"))


def loop(on: Surroundings) -> None:
    """The folder to write into is a link to itself."""
    on.out.rmdir()
    on.out.symlink_to(on.out)


def folders_for_files(on: Surroundings) -> None:
    """Folders have the names of the files."""
    for name in on.whole.files:
        (on.out / name / "own").mkdir(parents=True)


def set_to(**variables: str | None) -> Callable[[Surroundings], None]:
    """Variables of the environment, or none. WORLD stands for the world's folder."""

    def act(on: Surroundings) -> None:
        for name, value in variables.items():
            on.environment.pop(name, None)
            if value is not None:
                on.environment[name] = value.replace("WORLD", str(on.world.path))

    return act


def jumping_clock(begin: float, step: float) -> Callable[[Surroundings], None]:
    """A clock that is off, and that jumps at every look at it."""

    def act(on: Surroundings) -> None:
        place = on.world.path / "in" / "clock"
        place.mkdir()
        (place / "sitecustomize.py").write_text(
            "import time\n"
            f"_now, _off = time.time, [{begin!r}]\n"
            "def time_():\n"
            f"    _off[0] += {step!r}\n"
            "    return _now() + _off[0]\n"
            "time.time = time_\n"
            "time.time_ns = lambda: int(time_() * 1e9)\n"
        )
        on.environment["PYTHONPATH"] = f"{place}{os.pathsep}{on.environment['PYTHONPATH']}"

    return act


def files_of_the_future(on: Surroundings) -> None:
    """Everything was last changed in thirty years."""
    future = time.time() + 30 * 365 * 86400
    for place, folders, files in os.walk(on.world.path):
        for name in (*folders, *files):
            os.utime(Path(place, name), (future, future))


def without_fonts(on: Surroundings) -> None:
    """No font is installed, as the command sees it."""
    empty = on.world.path / "in" / "fonts"
    empty.mkdir()
    fonts = [
        folder for folder in ("/usr/share/fonts", "/usr/local/share/fonts") if Path(folder).is_dir()
    ]
    hide = " && ".join(f"mount --bind {empty} {folder}" for folder in fonts) or "true"
    on.prefix = ["unshare", "-m", "sh", "-c", f'{hide} && exec "$@"', "sh"]
    shutil.rmtree(on.world.path / "home" / ".cache", ignore_errors=True)
    on.environment |= {"FONTCONFIG_FILE": "/dev/null", "FONTCONFIG_PATH": str(empty)}


def words(*more: str) -> Callable[[Surroundings], None]:
    """More words of the command; of an option, the last one counts."""
    return lambda on: on.more.extend(more)


def stream(name: str, path: str, mode: int) -> Callable[[Surroundings], None]:
    """A stream that is a device."""

    def act(on: Surroundings) -> None:
        handle = os.open(path, mode)
        on.stack.callback(os.close, handle)
        on.streams[name] = handle

    return act


def closed(*numbers: int) -> Callable[[Surroundings], None]:
    """Streams that are not there at all."""
    return lambda on: on.first.extend(lambda number=number: os.close(number) for number in numbers)


def nobody_reads(on: Surroundings) -> None:
    """A pipe whose reader has gone, as behind `| head -1`."""
    reader, writer = os.pipe()
    os.close(reader)
    on.stack.callback(os.close, writer)
    on.streams["stdout"] = writer


def limited(kind: int, most: int) -> Callable[[Surroundings], None]:
    """A limit of the operating system on the process."""
    return lambda on: on.first.append(lambda: resource.setrlimit(kind, (most, most)))


def no_working_folder(on: Surroundings) -> None:
    """The working folder is gone when the command begins; it writes elsewhere."""
    place = on.world.path / "here" / "gone"
    on.first += [place.mkdir, lambda: os.chdir(place), place.rmdir]
    on.more += ["--out", str(on.out)]


def strict_mask(on: Surroundings) -> None:
    """New files and folders may not even be read by others."""
    on.first.append(lambda: os.umask(0o077) and None)


def nothing(_: Surroundings) -> None:
    """All is well, but for the command that runs at the same time."""


FAULTS = (
    *(
        Fault(f"disk of {k} kB", c, small_disk("here/out", k))
        for c, k in (
            ("run", 4),
            ("run", 24),
            ("run loaded", 120),
            ("fabricate", 40),
            ("thicken", 200),
            ("figure", 8),
            ("sweep", 16),
            ("sweep", 96),
            ("convert", 4),
            ("new", 4),
        )
    ),
    Fault("disk of 4 kB for the settings", "settings", small_disk("home", 4)),
    *(
        Fault("no room for temporary files", c, small_disk("tmp", 8))
        for c in ("run scan", "animate")
    ),
    *(
        Fault("read-only folder", c, read_only("here/out"))
        for c in ("run", "fabricate", "sweep", "new", "convert")
    ),
    Fault("read-only home", "settings", read_only("home")),
    Fault("read-only home", "figure", read_only("home"), is_harmless=True),
    Fault("read-only folder for temporary files", "run scan", read_only("tmp"), is_harmless=True),
    Fault("a user who may not write", "run", another_user),
    Fault("vanishing folder", "run", vanishing("here/out", is_made_again=False)),
    Fault(
        "vanishing folder that comes back", "fabricate", vanishing("here/out", is_made_again=True)
    ),
    Fault("vanishing temporary files", "run scan", vanishing("tmp", is_made_again=True)),
    Fault("vanishing folder of a sweep", "sweep", vanishing("here/out/parts", is_made_again=False)),
    *(
        Fault(f"links to {aim}", c, linked(aim), is_harmless=True)
        for aim, c in (
            ("nothing", "run"),
            ("itself", "fabricate"),
            ("file", "thicken"),
            ("file", "convert"),
        )
    ),
    Fault("links to nothing", "new", linked("nothing")),
    Fault("linked folder", "run", linked_folder),
    Fault("folder that links to itself", "run", loop),
    Fault("folders in the place of files", "fabricate", folders_for_files),
    Fault("two runs at once", "run", nothing, is_harmless=True, other="run"),
    Fault("two commands at once", "fabricate", nothing, is_harmless=True, other="run"),
    Fault("two sweeps at once", "sweep", nothing, is_harmless=True, other="sweep"),
    Fault("clock that is ten years late", "run scan", jumping_clock(-3e8, 0.0), is_harmless=True),
    Fault("clock that runs backwards", "sweep", jumping_clock(1e8, -3600.0), is_harmless=True),
    Fault("clock that leaps", "run loaded", jumping_clock(0.0, 1e6), is_harmless=True),
    Fault("files of the future", "sweep", files_of_the_future, is_harmless=True),
    Fault("no home", "figure", set_to(HOME=None), is_harmless=True),
    Fault("a home that is not there", "run loaded", set_to(HOME="/nonexistent"), is_harmless=True),
    Fault("settings where a file is", "settings", set_to(XDG_CONFIG_HOME="WORLD/in/x.fold")),
    Fault("no fonts", "figure", without_fonts, is_harmless=True),
    Fault("no fonts", "fabricate", without_fonts, is_harmless=True),
    *(
        Fault(
            f"locale {name}",
            c,
            set_to(LC_ALL=name, PYTHONUTF8="0", PYTHONCOERCECLOCALE="0"),
            is_harmless=True,
        )
        for name, c in (
            ("C", "fabricate"),
            ("POSIX", "run"),
            ("tr_TR.UTF-8", "thicken"),
            ("de_DE.UTF-8", "sweep"),
        )
    ),
    Fault("ASCII terminal", "templates", set_to(PYTHONIOENCODING="ascii"), is_harmless=True),
    *(
        Fault(f"width of {w} mm", c, words("--width-mm", w), makes_others=True)
        for c, w in (
            ("fabricate", "1e-7"),
            ("fabricate", "1e7"),
            ("thicken", "1e-7"),
            ("thicken", "3.4e38"),
            ("simulate", "1e-7"),
            ("simulate", "1e7"),
            ("convert", "1e-38"),
            ("animate", "1e300"),
        )
    ),
    *(
        Fault(f"width of {w} mm", "run", words("--set", f"sheet.width_mm={w}"), makes_others=True)
        for w in ("1e-7", "1e7", "16777217.0", "1e39")
    ),
    Fault("full output", "run", stream("stdout", "/dev/full", os.O_WRONLY), is_harmless=True),
    Fault(
        "full error output",
        "fabricate",
        stream("stderr", "/dev/full", os.O_WRONLY),
        is_harmless=True,
    ),
    Fault("closed output", "fabricate", closed(1), is_harmless=True),
    Fault("closed streams", "run", closed(0, 1, 2), is_harmless=True),
    Fault("nobody reads", "templates", nobody_reads, is_harmless=True),
    Fault("nobody reads", "run", nobody_reads, is_harmless=True),
    Fault("files of at most 4 kB", "run", limited(resource.RLIMIT_FSIZE, 4096)),
    Fault("few open files", "sweep", limited(resource.RLIMIT_NOFILE, 24)),
    Fault("no working folder", "run", no_working_folder, is_harmless=True),
    Fault("strict mask", "run", strict_mask, is_harmless=True),
)
