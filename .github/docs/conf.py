"""How the documentation site is built: `python -m sphinx -W .github/docs build/docs`.

The build uses no network, and the site loads nothing from elsewhere.
"""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

from sphinx.util import logging

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]

project = "quadfold"
author = "the contributors of quadfold"
copyright = "the contributors of quadfold"  # noqa: A001 - the name that Sphinx reads
try:
    release = installed_version("quadfold")
except ModuleNotFoundError:
    release = ""

# Sphinx looks for it before the pages are made
(Path(__file__).parent / "made" / "extra").mkdir(parents=True, exist_ok=True)

extensions = ["myst_parser"]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
smartquotes = False  # what is quoted may be copied
exclude_patterns = ["**/.*", "made_pages", "made/extra"]

html_theme = "furo"
html_title = "quadfold"
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_static_path = ["static"]
html_css_files = ["site.css"]
html_extra_path = ["made/extra"]


def setup(app):  # noqa: D103 - Sphinx calls it
    from made_pages import write_pages
    from made_pages.links import broken_links

    def write(app):
        write_pages(Path(app.srcdir) / "made")

    def check(app, error):
        if error is None and app.builder.name == "html":
            for broken in broken_links(Path(app.outdir)):
                logging.getLogger(__name__).warning(broken)

    app.connect("builder-inited", write)
    app.connect("build-finished", check)
