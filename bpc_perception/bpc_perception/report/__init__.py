"""What a measurement leaves behind for people: tables, summary, report, figures."""
