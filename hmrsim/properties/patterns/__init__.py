"""What watches over the patterns of Menghi et al., one file a family.

Claudio Menghi, Christos Tsigkanos, Patrizio Pelliccione, Carlo Ghezzi, Thorsten Berger: Specification Patterns for
Robotic Missions. IEEE Transactions on Software Engineering 47 (10), 2021. Their formulas are on
http://roboticpatterns.com.
"""
