"""The gallery: a page of all templates, and one for each with its job and its result page."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from fab.catalogue import PAPER, shipped, shipped_picture, template_groups
from fab.settings import read_toml

__all__ = ["gallery_pages", "results_made", "wanted_results"]

# Templates whose result pages take a few seconds each: where QUADFOLD_GALLERY = short, as in CI,
# only theirs are made; those of all take some minutes.
SHORT = ("miura", "rigid_miura", "cornered_miura", "strip_by_strip", "random_tube", "curved_fold")
_ABOUT = {
    "To use": "Things to make: copy one, give it your size and your stock.",
    "Designs to change": "One for each kind of sheet, with a comment on every key of its design.",
    PAPER: "The models of the paper in all their resolutions, some of them too fine to be cut.",
}


def wanted_results() -> tuple[str, ...]:
    """Templates whose result pages are made: QUADFOLD_GALLERY is all, short or none."""
    wanted = os.environ.get("QUADFOLD_GALLERY", "all")
    return {"short": SHORT, "all": tuple(shipped("jobs")), "none": ()}[wanted]


def gallery_pages(results: set[str]) -> dict[str, str]:
    """The pages by their names. results : templates that have a result page."""
    jobs = shipped("jobs")
    out = {"gallery.md": _gallery()}
    for name, path in jobs.items():
        out[f"gallery/{name}.md"] = _page(name, path, name in results)
    return out


def results_made(folder: Path) -> set[str]:
    """Make the result pages that are wanted into a folder, and say which are there.

    One that was made from the same job is kept.
    """
    from fab.jobs.job import load_job
    from fab.jobs.job_files import make

    stamps = folder.parent.parent / "stamps"
    for each in (folder, stamps):
        each.mkdir(parents=True, exist_ok=True)
    jobs = shipped("jobs")
    for name in wanted_results():
        stamp = stamps / f"{name}.sha256"
        digest = hashlib.sha256(jobs[name].read_bytes()).hexdigest()
        if stamp.is_file() and stamp.read_text() == digest:
            continue
        made = make(load_job(jobs[name]), ["html"])
        (folder / f"{name}.html").write_bytes(made.files[f"{name}.html"])
        stamp.write_text(digest)
    return {path.stem for path in folder.glob("*.html")}


def pictures_copied(folder: Path) -> None:
    """The pictures of all templates, for the pages."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in shipped("jobs"):
        picture = shipped_picture(name)
        if picture is not None:
            shutil.copyfile(picture, folder / f"{name}.png")


def _gallery() -> str:
    out = [
        "# Gallery: all templates\n",
        "`quadfold run NAME --out out` makes one as it is, `quadfold new NAME` copies it to be "
        "changed; "
        "`quadfold studio` shows all of them in a page where they can be changed at once.\n",
    ]
    for group, names in template_groups().items():
        out += [f"## {group}\n", _ABOUT[group] + "\n", '<div class="gallery">\n']
        out += [line for name in names for line in _card(name)]
        out.append("</div>\n")
    out.append(_tree())
    return "\n".join(out)


def _card(name: str) -> Iterator[str]:
    text = _description(name)
    yield "<figure>\n"
    if shipped_picture(name) is not None:
        yield f"[![{name}: {text}](gallery_pictures/{name}.png)](gallery/{name}.md)\n"
    yield f"<figcaption>\n\n[{name}](gallery/{name}.md): {text}\n\n</figcaption></figure>\n"


def _tree() -> str:
    names = "\n".join(f"gallery/{name}" for names in template_groups().values() for name in names)
    return f"```{{toctree}}\n:hidden:\n\n{names}\n```\n"


def _page(name: str, path: Path, has_result: bool) -> str:
    result = (
        f'<p><a href="../../results/{name}.html">Its result page</a>: folded and flat, findings, '
        "files and all numbers.</p>\n"
        if has_result
        else f"Its result page is made by `quadfold run {name} --only html`; "
        "this build left it out.\n"
    )
    picture = f"![{name}, folded](../gallery_pictures/{name}.png)\n"
    return "\n".join(
        [
            f"# {name}\n",
            f"{_description(name)[:1].upper()}{_description(name)[1:]}.\n",
            *([picture] if shipped_picture(name) is not None else []),
            result,
            f"```sh\nquadfold run {name} --out out\nquadfold new {name} --out mine.toml\n```\n",
            f"```toml\n{path.read_text('utf-8').strip()}\n```\n",
            f"Keys: [of its design](#design-{_kind(path)}), [of a job](../job_keys.md).\n",
        ]
    )


def _description(name: str) -> str:
    return str(read_toml(shipped("jobs")[name], "").get("description", "")).rstrip(".")


def _kind(path: Path) -> str:
    return str(read_toml(path, "")["design"]["kind"])
