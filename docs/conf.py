"""Settings of the documentation site, which ``make docs`` builds; nothing is fetched for it."""

import sys
from pathlib import Path

from nonsmooth.version import __version__

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "nonsmooth"
author = "The nonsmooth developers"
project_copyright = author
version = release = __version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "backticks",
    "commands",
    "mathml",
    "outside",
]
exclude_patterns = ["_extensions", "_templates", "gallery"]
templates_path = ["_templates"]
smartquotes = False  # texts have the signs that they mean, such as -- of an option
default_role = "public"  # of docstrings and gallery: see _extensions/backticks.py

# ---------------------------------------------------------------- pages

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # types stand in the sections of numpydoc
numpydoc_show_class_members = False  # the template of classes lists them
python_maximum_signature_line_length = 80
toc_object_entries = False

copybutton_prompt_text = ">>> "
copybutton_exclude = ".linenos, .gp, .go"

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "auto_gallery",
    "subsection_order": [
        f"gallery/{name}" for name in ("impacts", "friction", "mole", "chaos", "rotor", "fatigue")
    ],
    "within_subsection_order": "FileNameSortKey",
    "backreferences_dir": "auto_gallery/uses",
    "doc_module": ("nonsmooth",),
    "reference_url": {"nonsmooth": None},
    "reset_modules": ("matplotlib",),
    "capture_repr": (),  # what is printed is shown; the last value of a block is not
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e6,  # seconds: those of one machine say nothing on another
    "write_computation_times": False,
}

# ---------------------------------------------------------------- looks

html_theme = "pydata_sphinx_theme"
html_title = "nonsmooth"
html_logo = html_favicon = "_static/logo.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "logo": {"text": "nonsmooth"},
    "header_links_before_dropdown": 8,
    "show_toc_level": 2,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars = {"index": [], "getting-started": [], "glossary": []}
