"""The documentation's settings.

Build: sphinx-build -W --keep-going -n -b html docs build/site
"""

import os
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "build_scripts" / "site")]

os.environ |= {
    "POLARS_FMT_MAX_ROWS": "20",
    "POLARS_FMT_STR_LEN": "60",
    "POLARS_FMT_TABLE_HIDE_COLUMN_DATA_TYPES": "1",
    "POLARS_FMT_TABLE_HIDE_DATAFRAME_SHAPE_INFORMATION": "1",
}  # tables of the gallery, as short as they can be read

project = "pipeclamp"
author = "The pipeclamp engineers"
project_copyright = f"2026, {author}"
version = release = installed_version("pipeclamp")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
    "sphinx_design",
    "mathml",
    "command_reference",
    "effect_pages",
    "schema_reference",
    "house",
    "line_breaks",
]
exclude_patterns = ["_build", "examples"]
nitpicky = True
nitpick_ignore_regex = [("py:.*", r"(?!pipeclamp\.).*")]  # other projects' names: their sites are out of reach
python_use_unqualified_type_names = True
autodoc_preserve_defaults = True
autodoc_class_signature = "separated"
toc_object_entries_show_parents = "hide"
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
add_module_names = False
napoleon_numpy_docstring = False
napoleon_use_rtype = False
napoleon_custom_sections = ["Source"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
myst_dmath_double_inline = True

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": "/plot_",
    "abort_on_example_error": True,
    "capture_repr": ("_repr_html_",),
    "image_srcset": ["2x"],
    "min_reported_time": 10_000,
    "show_memory": False,
    "show_signature": False,
    "within_subsection_order": "FileNameSortKey",
    "write_computation_times": False,
}

highlight_language = "text"
html_math_renderer = "mathml"
html_theme = "furo"
html_title = "pipeclamp"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}
copybutton_prompt_text = r"^\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True
