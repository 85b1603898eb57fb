"""Cookies from drawn cubes of dough, by both trees."""
