"""Sphinx's settings. build_site.py lays out the pages and calls it."""
import logging
import os
import re

project = "myogrowth"
author = "the myogrowth authors"
version = release = os.environ["MYOGROWTH_VERSION"]
root_doc = "index"
extensions = ["myst_parser", "breathe", "sphinx.ext.mathjax", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = f"myogrowth {release}"
html_static_path = [os.environ["MYOGROWTH_STATIC"]]
html_css_files = ["site.css"]
html_show_sphinx = False
html_show_copyright = False
html_copy_source = False
html_show_sourcelink = False
pygments_style = "friendly"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4

# MathJax 2.7, copied into the site: formulas are drawn as SVG, without a network.
mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_SVG"
mathjax2_config = {
    "showMathMenu": False,
    "messageStyle": "none",
    "SVG": {"font": "TeX", "scale": 90},
    "tex2jax": {"processClass": "math", "ignoreClass": ".*", "inlineMath": [["\\(", "\\)"]],
                "displayMath": [["\\[", "\\]"]]},
}

breathe_projects = {"myogrowth": os.environ["MYOGROWTH_DOXYGEN_XML"]}
breathe_default_project = "myogrowth"
breathe_show_include = False
autodoc_member_order = "bysource"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Floats", "Measure")}
autodoc_preserve_defaults = True

# Every header opens the namespaces again, which Sphinx takes for second declarations.
logging.getLogger("sphinx.sphinx.domains.cpp").addFilter(
    lambda record: not re.search(r"Duplicate.*cpp:type:: (myogrowth|batch|simd)'", record.getMessage(), re.S))
