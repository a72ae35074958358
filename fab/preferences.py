"""What users have set for themselves: the stock they mostly take, and a folder of their own stock.

Both are in the platform's folder for settings: `settings.toml`, and `materials` and `machines`, in
which every TOML file is known by its name like a shipped one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import Field

from fab.errors import InvalidJob, did_you_mean
from fab.files import shown_path
from fab.scratch import replaced
from fab.settings import Settings, checked, read_toml

__all__ = ["Preferences", "own_files", "preferences", "preferences_file", "set_preference"]

_CURE = "Mend or delete the file."


class Preferences(Settings):
    """Names or paths of the stock that commands take where none is given."""

    material: str | None = Field(default=None, description="sheet that is cut")
    machine: str | None = Field(default=None, description="laser cutter or plotter")
    printer: str | None = Field(default=None, description="3D printer")
    print_material: str | None = Field(default=None, description="what it prints with")


def preferences_file() -> Path:
    """Where the preferences are kept, whether they are there or not."""
    from platformdirs import user_config_path

    return user_config_path("quadfold", appauthor=False) / "settings.toml"


def preferences() -> Preferences:
    """The preferences; none where there is no file. Raises `InvalidJob` with every key at fault."""
    path = preferences_file()
    if not path.is_file():
        return Preferences()
    return checked(Preferences, read_toml(path, _CURE), str(path), _CURE)


def set_preference(key: str, value: str | None) -> Path:
    """Set a preference, or remove it; the file, whose comments and other keys stay.

    Raises `InvalidJob` for an unknown key and where the file cannot be written.
    """
    import tomlkit

    known = list(Preferences.model_fields)
    if key not in known:
        hint = did_you_mean(key, known)
        raise InvalidJob(f"{key!r} is no setting; it must be one of {', '.join(known)}.{hint}")
    preferences()  # a faulty file is not written over
    path = preferences_file()
    try:
        text = path.read_text("utf-8-sig") if path.is_file() else ""
        document = tomlkit.parse(text)
        if value is None:
            document.pop(key, None)
        else:
            document[key] = value
        path.parent.mkdir(parents=True, exist_ok=True)
        with replaced(path.resolve()) as written:  # which may be a link to a file kept elsewhere
            written.write_text(tomlkit.dumps(document), "utf-8")
    except OSError as error:
        why = error.strerror or type(error).__name__
        cure = "Make room there, or make its folder one that you may write to."
        raise InvalidJob(f"{shown_path(path)}: cannot be written: {why}. {cure}") from error
    return path


def own_files(folder: Literal["materials", "machines"]) -> dict[str, Path]:
    """TOML files of the user's own materials or machines by name, sorted."""
    place = preferences_file().parent / folder
    return {path.stem: path for path in sorted(place.glob("*.toml"))}
