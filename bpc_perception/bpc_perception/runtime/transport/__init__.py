"""How Fast DDS carries messages: profiles, and the shared memory that killed processes leave."""
