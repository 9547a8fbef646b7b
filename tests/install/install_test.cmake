# Installs the build into a fresh prefix, builds the consumer against it alone, and runs it.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY OUTPUT_VARIABLE output ERROR_VARIABLE output)
  set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/build -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${WORK}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/build/consumer ${SAMPLES}/meshes/torus.obj ${WORK}/torus.msh)
if(NOT output MATCHES "^[0-9]+ tets" OR NOT EXISTS ${WORK}/torus.msh)
  message(FATAL_ERROR "the consumer printed: ${output}")
endif()

# The installed program finds its data beside it, far from the sources.
run(${WORK}/prefix/bin/isochor mesh ${WORK}/prefix/share/isochor/samples/meshes/torus.obj --voxels 64
    -o ${WORK}/installed.msh -q)
foreach(file IN ITEMS share/man/man1/isochor.1 share/bash-completion/completions/isochor
        share/zsh/site-functions/_isochor share/isochor/samples/index.json share/isochor/web/bundle/index.html
        include/isochor/core/pipeline/pipeline.h)
  if(NOT EXISTS ${WORK}/prefix/${file})
    message(FATAL_ERROR "${file} is not installed")
  endif()
endforeach()
