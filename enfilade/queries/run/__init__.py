"""Running a question: statements to rows, rows to matches, matches to a ranked answer."""
