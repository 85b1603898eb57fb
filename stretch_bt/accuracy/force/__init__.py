"""Force models against forces that they have not seen."""
