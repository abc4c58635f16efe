"""Security: a certificate authority, and least privilege by role.

`keystore` creates and changes the folder of ``hmrsim security``, `roles` defines the rights of each role, and `check`
tests them against a running simulator. Using an enclave needs none of this: see `hmrsim_zenoh.wire.enclave`.
"""
