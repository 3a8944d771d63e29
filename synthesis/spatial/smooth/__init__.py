"""A spatial cam's body bounded by its true surfaces, face by face: no boolean cuts."""
