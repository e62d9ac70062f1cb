"""What is written about a measurement for people: tables, summary, report, figures."""
