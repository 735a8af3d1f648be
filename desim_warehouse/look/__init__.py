"""Look of pages: colours, templates, and the one file that a page is."""
