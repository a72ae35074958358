"""How the documentation site is built: `python -m sphinx -W .github/docs build/docs`.

The build uses no network, and the site loads nothing from elsewhere.
"""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

project = "quadfold"
author = "the contributors of quadfold"
copyright = "the contributors of quadfold"  # noqa: A001 - the name that Sphinx reads
try:
    release = installed_version("quadfold")
except ModuleNotFoundError:
    release = ""

extensions = ["myst_parser"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["**/.*", "made_pages"]

html_theme = "furo"
html_title = "quadfold"
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False


def setup(app):  # noqa: ANN001, ANN201, D103 - Sphinx calls it
    from made_pages import write_pages

    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir) / "made"))
