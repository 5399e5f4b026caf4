"""The site of docs/, made by ``make docs``: MyST reads the pages, autodoc the docstrings of the package."""

from importlib.metadata import version as installed

from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers
from sphinx.util.inspect import TypeAliasForwardRef

project = html_title = "tfra"
version = release = installed("tfra")

extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_heading_anchors = 4
smartquotes = False  # options of commands keep their two dashes
highlight_language = "text"
lexers["console"] = TextLexer()  # most of such a block is what a command answers, which is no language

# Members stand in the order of their source; types have the names that the source gives them.
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_type_aliases = {name: name for name in ("Floats", "Ints", "Bools", "npt.ArrayLike")}
TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # Sphinx prints its own class in `Floats | None`
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100

html_theme = "furo"
html_copy_source = html_show_copyright = False
