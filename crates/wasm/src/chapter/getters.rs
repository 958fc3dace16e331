//! The getters that simulations with steps of a fixed length share.

/// Getters of the step length `STEP`, the time, q and q̇, with the documentation of q and q̇.
macro_rules! state_getters {
    ($simulation:ty: $(#[$q:meta])* q, $(#[$qd:meta])* qd) => {
        #[wasm_bindgen]
        impl $simulation {
            /// The step \[s\].
            #[wasm_bindgen(getter, js_name = stepLength)]
            pub fn step_length(&self) -> f64 {
                STEP
            }

            /// Time since the start \[s\].
            #[wasm_bindgen(getter)]
            pub fn time(&self) -> f64 {
                self.steps as f64 * STEP
            }

            $(#[$q])*
            #[wasm_bindgen(getter)]
            pub fn q(&self) -> Vec<f64> {
                self.q.as_slice().to_vec()
            }

            $(#[$qd])*
            #[wasm_bindgen(getter)]
            pub fn qd(&self) -> Vec<f64> {
                self.qd.as_slice().to_vec()
            }
        }
    };
}
