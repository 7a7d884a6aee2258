"""Drop-in replacements for modules of other packages, with their function names, arguments and results."""
