"""Protocols: under which light a view is rendered, and which of its pixels count."""
