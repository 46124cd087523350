"""A trained scene as one web page that relights it live (docs/view.md)."""
