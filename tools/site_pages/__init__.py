"""The pages of the documentation's site that are made from the code; `tools/make_site.py` builds them."""
