"""Pages for people: HTML files that hold all they need and open without a network."""
