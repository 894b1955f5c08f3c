"""Every number of the documentation, traced to what makes it and made again: `make claims`.

`numerals` finds numbers and the rules by which some claim nothing, `page` the blocks of a page, `trace` what each
number is traced by, `told` the passages that are written again from results, `steps` what takes minutes.
"""
