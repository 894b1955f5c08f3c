"""The report on the circle test and the sine test: thesis figures, tables beside the published ones, findings."""
