//! Devices with Vulkan, Metal or DirectX 12, through wgpu.

use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::task::{Context, Poll, Waker};

use robot_dynamics_generate::{GeneratedFiles, Precision, Target, WGSL_WORKGROUP};

use super::{Backend, Command, TableCounts};
use crate::{DeviceError, Limits};

/// A device, and the queue of its commands.
pub(crate) struct Wgpu {
    name: String,
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// An error that no call has returned yet.
    failure: Arc<Mutex<Option<String>>>,
}

/// A shader, and the layout of its tables.
pub(crate) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

/// A shader with its tables.
pub(crate) struct Launch {
    pipeline: wgpu::ComputePipeline,
    tables: wgpu::BindGroup,
    workgroups: u32,
}

/// Waits for a future. On native devices wgpu's futures are ready at the first poll.
fn block_on<T>(future: impl Future<Output = T>) -> T {
    let mut future = core::pin::pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(result) = future.as_mut().poll(&mut context) {
            return result;
        }
        std::thread::yield_now();
    }
}

impl Wgpu {
    /// Opens the first device, preferably a graphics processor.
    ///
    /// # Errors
    /// [`DeviceError::NoDevice`]; [`DeviceError::Closed`] if the device lacks the features of the shaders.
    pub(crate) fn open(limits: Limits) -> Result<Self, DeviceError> {
        let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
        description.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
        // The default flags of an unoptimised build add the line of each operation, which takes quadratic
        // time for long shaders.
        description.flags = wgpu::InstanceFlags::empty();
        let instance = wgpu::Instance::new(description);
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = block_on(instance.request_adapter(&options))
            .map_err(|error| DeviceError::NoDevice { cause: error.to_string() })?;
        let info = adapter.get_info();
        let name = format!("{}, {}", info.name, info.backend);
        let mut required_limits = adapter.limits();
        if let Some(most) = limits.table_bytes {
            required_limits.max_storage_buffer_binding_size =
                most.min(required_limits.max_storage_buffer_binding_size);
        }
        if let Some(most) = limits.launch_states {
            let workgroups = u32::try_from((most / WGSL_WORKGROUP).max(1)).unwrap_or(u32::MAX);
            let most = &mut required_limits.max_compute_workgroups_per_dimension;
            *most = workgroups.min(*most);
        }
        let description =
            wgpu::DeviceDescriptor { label: Some("robot-dynamics"), required_limits, ..Default::default() };
        let (device, queue) = block_on(adapter.request_device(&description))
            .map_err(|error| DeviceError::Closed { device: name.clone(), cause: error.to_string() })?;
        let failure = Arc::new(Mutex::new(None));
        let found = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            found.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error.to_string());
        }));
        Ok(Self { name, device, queue, failure })
    }

    fn failed(&self, cause: &impl ToString) -> DeviceError {
        DeviceError::Failed { device: self.name.clone(), cause: cause.to_string() }
    }

    /// Returns the error that occurred since the last check.
    fn check(&self) -> Result<(), DeviceError> {
        match self.failure.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(cause) => Err(self.failed(&cause)),
            None => Ok(()),
        }
    }

    /// The layout of the tables that are read, followed by those that are written.
    fn layout(&self, tables: TableCounts) -> wgpu::BindGroupLayout {
        let entry = |binding: usize| wgpu::BindGroupLayoutEntry {
            binding: number(binding),
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: binding < tables.reads },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        let entries: Vec<_> = (0..tables.reads + tables.writes).map(entry).collect();
        self.device
            .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
    }
}

fn number(x: usize) -> u32 {
    u32::try_from(x).expect("fewer than 2³² tables and workgroups")
}

impl Backend for Wgpu {
    type Buffer = wgpu::Buffer;
    type Kernel = Kernel;
    type Launch = Launch;

    const TARGET: Target = Target::Wgsl;

    fn name(&self) -> &str {
        &self.name
    }

    fn has(&self, precision: Precision) -> bool {
        precision == Precision::Single
    }

    fn most_bytes(&self) -> usize {
        let limits = self.device.limits();
        let most = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        usize::try_from(most).unwrap_or(usize::MAX)
    }

    fn most_states(&self) -> usize {
        self.device.limits().max_compute_workgroups_per_dimension as usize * WGSL_WORKGROUP
    }

    fn compile(
        &self,
        generated: &GeneratedFiles,
        symbol: &str,
        tables: TableCounts,
    ) -> Result<Kernel, String> {
        let file = generated.file(&format!("robot_{symbol}.wgsl")).ok_or("no such shader was generated")?;
        let scopes =
            [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation]
                .map(|filter| self.device.push_error_scope(filter));
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(symbol),
            source: wgpu::ShaderSource::Wgsl(file.text.as_str().into()),
        });
        let layout = self.layout(tables);
        let pipeline_layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(symbol),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        // The last scope is the innermost.
        let errors: Vec<_> = scopes.into_iter().rev().filter_map(|scope| block_on(scope.pop())).collect();
        match errors.first() {
            Some(error) => Err(error.to_string()),
            None => Ok(Kernel { pipeline, layout }),
        }
    }

    fn allocate(&self, bytes: usize) -> Result<wgpu::Buffer, DeviceError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.buffer(bytes, usage)
    }

    fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) -> Result<(), DeviceError> {
        self.queue.write_buffer(buffer, 0, bytes);
        self.check()
    }

    fn read(&self, buffer: &wgpu::Buffer, bytes: &mut [u8]) -> Result<(), DeviceError> {
        let here = self.buffer(bytes.len(), wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST)?;
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &here, 0, bytes.len() as u64);
        self.queue.submit([encoder.finish()]);
        let (sender, receiver) = mpsc::channel();
        here.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // If waiting failed, the receiver is dropped.
            let _ = sender.send(result);
        });
        self.wait()?;
        match receiver.recv() {
            Ok(Ok(())) => {
                let range = here.slice(..).get_mapped_range().map_err(|error| self.failed(&error))?;
                bytes.copy_from_slice(&range);
                Ok(())
            }
            Ok(Err(error)) => Err(self.failed(&error)),
            Err(_) => Err(self.failed(&"the results were not mapped")),
        }
    }

    fn bind(&self, kernel: &Kernel, tables: &[(&wgpu::Buffer, usize)], states: usize) -> Launch {
        let entries: Vec<_> = (tables.iter().enumerate())
            .map(|(binding, &(buffer, bytes))| wgpu::BindGroupEntry {
                binding: number(binding),
                // The shader derives the number of states from the length of the first table.
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer,
                    offset: 0,
                    size: core::num::NonZero::new((states * bytes) as u64),
                }),
            })
            .collect();
        let tables = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &kernel.layout,
            entries: &entries,
        });
        let workgroups = number(states.div_ceil(WGSL_WORKGROUP));
        Launch { pipeline: kernel.pipeline.clone(), tables, workgroups }
    }

    fn submit(&self, commands: &[Command<'_, Self>]) -> Result<(), DeviceError> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for command in commands {
            match command {
                // wgpu synchronises a pass with the writes of those before it.
                Command::Run(launch) => {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                    pass.set_pipeline(&launch.pipeline);
                    pass.set_bind_group(0, &launch.tables, &[]);
                    pass.dispatch_workgroups(launch.workgroups, 1, 1);
                }
                Command::Copy { from, from_at, to, to_at, bytes } => {
                    encoder.copy_buffer_to_buffer(from, *from_at as u64, to, *to_at as u64, *bytes as u64);
                }
            }
        }
        self.queue.submit([encoder.finish()]);
        self.check()
    }

    fn wait(&self) -> Result<(), DeviceError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| self.failed(&error))?;
        self.check()
    }
}

impl Wgpu {
    fn buffer(&self, bytes: usize, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, DeviceError> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let size = bytes as u64;
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage,
            mapped_at_creation: false,
        });
        match block_on(scope.pop()) {
            Some(error) => {
                Err(self.failed(&format!("{error} for {bytes} bytes; compute fewer states at once")))
            }
            None => self.check().map(|()| buffer),
        }
    }
}
