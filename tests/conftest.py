from hypothesis import settings

settings.register_profile("shared", deadline=None)  # how fast a machine is, is no property of the code
settings.load_profile("shared")
