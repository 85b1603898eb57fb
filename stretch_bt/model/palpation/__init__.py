"""What force and height say of the object, and where to press next."""
