"""Hard cases: mechanisms and states where code goes wrong first, each with the answer that is right."""
