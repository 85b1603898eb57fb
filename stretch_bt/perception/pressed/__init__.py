"""The whole membrane under a press by a sphere, as the solved sheet has it."""
