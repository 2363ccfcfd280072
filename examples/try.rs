use raceway::physics::bearing::*; use raceway::physics::cage::*; use raceway::physics::contact::damping::*; use raceway::physics::contact::traction::*;
use raceway::physics::lubricant::*; use raceway::physics::material::*; use raceway::physics::operation::*; use raceway::physics::spindle::*;
use raceway::simulation::run::*; use raceway::simulation::scene::*; use raceway::simulation::channel::*;
fn main(){
 let a: Vec<String> = std::env::args().collect();
 let get=|k:&str,d:f64| a.iter().find_map(|s| s.strip_prefix(&format!("{k}=")).map(|v| v.parse().unwrap())).unwrap_or(d);
 let steel=Material{elastic_modulus:219e9,poisson_ratio:0.3,density:7830.};
 let speed=get("rpm",50000.)*std::f64::consts::PI/30.;
 let p=SceneParameters{
  bearing:BearingParameters{kind:BearingKind::Integrated,outer_diameter:18e-3,inner_diameter:8.5e-3,width:5.9e-3,ball_count:7,ball_diameter:2.778e-3,pitch_diameter:13e-3,groove_curvature:PerRaceway{inner:0.529,outer:0.529},fit:Fit::RadialClearance(get("pd",5.)*1e-6),ball_material:steel,raceway_material:PerRaceway{inner:steel,outer:steel}},
  cage:CageParameters{material:Material{elastic_modulus:1e9,poisson_ratio:0.39,density:1100.},mass:0.13e-3,axial_inertia:5.5e-9,transverse_inertia:3e-9,offset:0.7e-3,pocket_clearance:51e-6,seat:PocketSeat::Open,rim_angle:65f64.to_radians(),seat_half_width:1e-3,film:if get("film",1.)>0.{PocketFilm::Wedge}else{PocketFilm::None},friction:0.08,friction_speed:0.05,bar_stiffness:None,land:None,damping:DampingLaw::Restitution{restitution:0.6,at_speed:0.1}},
  spindle:Spindle{mass:0.05,unbalance:if get("g",0.)>0.{Unbalance::Grade(get("g",0.)*1e-3)}else{Unbalance::None},axial:if get("fa",0.)!=0.{AxialHold::Free}else{AxialHold::Fixed}},
  operation:Operation{speed:SpeedProfile::constant(speed).unwrap(),load:[get("fa",0.),get("fy",200.),0.],misalignment:[0.;2]},
  lubricant:Lubricant{kind:LubricantKind::Grease,viscosity:0.02,pressure_viscosity:2e-8,fill:0.05,inlet_distance:None,traction:TractionLaw::FourParameter{at_rest:0.,maximum:0.05,at_slip:1.0,limit:0.036}},
  raceway_damping:DampingLaw::Restitution{restitution:0.9,at_speed:0.1},terms:Terms::default(),gravity:9.81};
 let scene=Scene::new(p).unwrap();
 let ya=Channel::Spindle(Axis::Y,Motion::Acceleration); let za=Channel::Spindle(Axis::Z,Motion::Acceleration);
 let s=RunSettings{method:Method::Auto,rung:if get("planar",0.)>0.{Some(Rung::Planar)}else{None},relative_tolerance:get("tol",1e-5),model_tolerance_db:0.05,fixed_step:None,settle:get("settle",0.02),duration:get("dur",0.1),outputs:Outputs{vibration:true,contacts:true,cage:true,spectra:vec![ya,za],series:vec![]}};
 let r=run(&scene,&s,&Control{stop:&||false,progress:&|_|{}}).unwrap();
 if get("brief",0.)>0. { let f=|c:Channel|{r.summary.channels.iter().find(|x|x.0==c).unwrap().1.level_db.unwrap()};
   let line=|c:Channel,l:&str| r.summary.lines.iter().find(|x|x.0==c&&x.1.label==l).map_or(0.,|x|x.1.amplitude);
   println!("pd {} y {:.3} z {:.3} err {:?} {:?} {:.0}/s | y BPFO {:.2} 2BPFO {:.2} z BPFO {:.2} 2BPFO {:.2} steps {} wall {:.2}",get("pd",5.),f(ya),f(za),r.summary.accuracy.level_error_db,r.summary.accuracy.motion,r.summary.accuracy.divergence_rate,line(ya,"BPFO"),line(ya,"2·BPFO"),line(za,"BPFO"),line(za,"2·BPFO"),r.summary.solver.statistics.steps,r.summary.solver.wall_time); return;}
 for (c,m) in &r.summary.channels { println!("{c} {m:?}"); }
 println!("{:?}\n{:?}\n{:?}\n{:?}",r.summary.contacts,r.summary.cage,r.summary.frequencies,r.summary.accuracy);
 println!("{:?}",r.summary.solver);
 for (c,l) in &r.summary.lines { println!("{c} {:.1} Hz {:.4} {} dev {:.2}",l.frequency,l.amplitude,l.label,l.deviation); }
 for l in &r.left_out {println!("{l:?}");}
}
