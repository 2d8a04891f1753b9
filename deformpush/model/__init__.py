"""What is learnt from pushes: how the error changes (paper), or how the object moves."""
