"""A material-point model of dough, apart from the product: another code and other physics to hold the reduced body against."""
