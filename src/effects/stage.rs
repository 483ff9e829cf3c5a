//! Places of effects in the chain.

/// Place in the chain; effects act in this order, and within a stage in the order of the model file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Between command and motor.
    Servo,
    /// Between motor and output of the gear; acts in the order of movement.
    Gear,
    /// Between the gear and the joint's position.
    Link,
    /// Kinematic parameters.
    Geometry,
    /// The base of the robot.
    Base,
    /// The TCP, in the frame of the base.
    Tcp,
    /// The measuring system.
    Measurement,
}

impl Stage {
    /// As the documents print it.
    pub fn text(self) -> &'static str {
        match self {
            Self::Servo => "servo",
            Self::Gear => "gear",
            Self::Link => "link",
            Self::Geometry => "geometry",
            Self::Base => "base",
            Self::Tcp => "TCP",
            Self::Measurement => "measurement",
        }
    }
}
