"""Orders exported by a WMS or ERP, converted by `desim orders` to the plain table that models read.

`export` reads the table, whatever its form, `cells` reads times and numbers as people write
them; `day` puts together what is in it, what is wrong with it and what was assumed.
"""
