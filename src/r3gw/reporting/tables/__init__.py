"""Tables over many runs, as CSV, Markdown and LaTeX."""
