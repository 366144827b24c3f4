"""How accurate the compiled code is: errors against ball arithmetic, states sought for, and proven bounds."""
