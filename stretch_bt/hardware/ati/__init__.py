"""ATI force and torque sensors that stream by UDP (RDT), such as the Axia80."""
