//! TODO: free_body_exact
