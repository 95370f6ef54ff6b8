"""The figures of Orvalho, Zacur, Susin, *Transferring Facial Expressions to Different Face Models*."""
