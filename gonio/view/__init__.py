"""The interactive viewer: `gonio view`, pages that are one file, and a widget for notebooks."""
