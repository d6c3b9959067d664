"""A report of one arm: a page that stands alone (`page`), and figures for papers (`figures`)."""
