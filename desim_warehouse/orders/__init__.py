"""Orders exported by a WMS or ERP, converted by `desim orders` to the plain table that models read.

`export` reads the table in any format, `cells` parses times and numbers in common notations, and `day` collects the
orders, the problems and the assumptions.
"""
