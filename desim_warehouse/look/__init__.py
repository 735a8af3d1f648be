"""How pages look: colours, templates, and the one file that a page is."""
