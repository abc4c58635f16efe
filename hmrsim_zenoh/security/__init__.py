"""Security: certificates by an authority of its own, and least rights by role.

`keystore` makes and changes the folder of ``hmrsim security``, `roles` says what each role may do, and `check` proves
it against a running simulator. Using an enclave needs none of this: see `hmrsim_zenoh.wire.enclave`.
"""
