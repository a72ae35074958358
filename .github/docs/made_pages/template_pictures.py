"""Pictures of the shipped jobs: `python .github/docs/made_pages/template_pictures.py [NAME ...]`.

They are made into templates/pictures, and committed: the gallery of the documentation and of the
studio show them. All of them take several minutes; after a change of a template, name it.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# Colours of a picture, which keep it small.
_COLOURS = 32


def small(data: bytes) -> bytes:
    """A PNG with few colours."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(io.BytesIO(data)) as image:
        image.convert("RGB").quantize(
            _COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE
        ).save(out, format="png", optimize=True)
    return out.getvalue()


def main(names: list[str]) -> None:
    """Make the pictures of these jobs, or of all."""
    from fab.catalogue import shipped
    from fab.studio.tasks import picture

    jobs = shipped("jobs")
    for name in names or jobs:
        (ROOT / "templates" / "pictures" / f"{name}.png").write_bytes(
            small(picture(str(jobs[name])))
        )


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    main(sys.argv[1:])
